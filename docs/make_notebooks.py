"""Run the notebooks of examples/notebooks; render them, with what they show, into docs/notebooks.

Run it from anywhere: python docs/make_notebooks.py [NAME …]
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from matplotlib.figure import Figure
from pandas import DataFrame, Series

DOCS = Path(__file__).parent
NOTEBOOKS = DOCS.parent / "examples/notebooks"
PAGES = DOCS / "notebooks"


def main(names: list[str]) -> None:
    """Render those named, or all."""
    PAGES.mkdir(exist_ok=True)
    for file in sorted(NOTEBOOKS.glob("*.ipynb")):
        if not names or file.stem in names:
            (PAGES / f"{file.stem}.md").write_text(rendered(file, PAGES), encoding="utf-8")
            print(file.stem, flush=True)


def cells(file: Path) -> Iterator[tuple[str, str]]:
    """The kind and text of every cell."""
    for cell in json.loads(file.read_text(encoding="utf-8"))["cells"]:
        yield cell["cell_type"], "".join(cell["source"])


def rendered(file: Path, folder: Path) -> str:
    """The notebook as a page, every cell run where the file lies; its figures go into `folder`."""
    scope: dict[str, Any] = {"__name__": "__main__"}
    parts = []
    with contextlib.chdir(file.parent), TemporaryDirectory() as own:
        for kind, source in cells(file):
            if kind == "markdown":
                parts.append(source)
                continue
            parts.append(f"```python\n{source}\n```")
            parts += [
                _shown(one, file.stem, folder, len(parts))
                for one in run(source, scope, Path(own) / f"cell_{len(parts)}.py")
            ]
    link = os.path.relpath(file, DOCS / "notebooks").replace(os.sep, "/")
    parts.insert(1, f"*[{file.name}]({link}), as `docs/make_notebooks.py` has run it.*")
    return "\n\n".join(parts) + "\n"


def run(source: str, scope: dict[str, Any], file: Path) -> Iterator[object]:
    """What a cell prints, and the value of its last line if that is an expression. Its text goes
    into `file`: compiled laws are kept by where they come from."""
    file.write_text(source, encoding="utf-8")
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    said, value = io.StringIO(), None
    with contextlib.redirect_stdout(said):
        exec(compile(tree, str(file), "exec"), scope)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), str(file), "eval"), scope)
    if said.getvalue():
        yield said.getvalue().rstrip()
    if value is not None:
        yield value


def _shown(value: object, name: str, folder: Path, number: int) -> str:
    if isinstance(value, Figure):
        value.savefig(folder / f"{name}-{number}.png", dpi=100, bbox_inches="tight")
        return f"![What the cell above draws]({name}-{number}.png)"
    if isinstance(value, DataFrame | Series):
        value = value.to_string(float_format="{:.4g}".format)
    return f"```text\n{value}\n```"


if __name__ == "__main__":
    main(sys.argv[1:])
