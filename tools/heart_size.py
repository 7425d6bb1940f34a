"""How large `diagnose/` is: lines, files, named constants, the longest functions.

    python tools/heart_size.py [FOLDER]

A constant is a number, or a tuple with one, that a module names in capitals; files without code
other than a docstring are not counted.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path

DIAGNOSE = Path(__file__).parents[1] / "host" / "wheelhop" / "diagnose"
LONG = 60  # lines


def constants(module: ast.Module) -> list[str]:
    """The names of numbers that a module states."""
    found = []
    for statement in module.body:
        targets = statement.targets if isinstance(statement, ast.Assign) else []
        if isinstance(statement, ast.AnnAssign) and statement.value is not None:
            targets = [statement.target]
        names = [n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name)]
        value = getattr(statement, "value", None)
        numbers = [
            n
            for n in (ast.walk(value) if value is not None else ())
            if isinstance(n, ast.Constant) and isinstance(n.value, int | float)
        ]
        found += [name for name in names if name.isupper() and numbers]
    return found


def functions(module: ast.Module) -> list[tuple[int, str]]:
    """Every function with the number of its lines."""
    kinds = ast.FunctionDef, ast.AsyncFunctionDef
    return [
        ((node.end_lineno or node.lineno) - node.lineno + 1, node.name)
        for node in ast.walk(module)
        if isinstance(node, kinds)
    ]


def main() -> None:
    """Print it, file by file and in all."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else DIAGNOSE
    lines = files = 0
    named: list[str] = []
    longest: list[tuple[int, str]] = []
    for path in sorted(folder.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        module = ast.parse(text)
        if len(module.body) < 2:
            continue
        here, count = constants(module), len(text.splitlines())
        print(f"{count:5} {path.relative_to(folder)}: {' '.join(here)}")
        lines, files, named = lines + count, files + 1, named + here
        longest += functions(module)
    print(f"{lines} lines, {files} files, {len(named)} constants")
    print("longest:", ", ".join(f"{name} {count}" for count, name in sorted(longest)[:-6:-1]))
    print(f"{sum(count > LONG for count, _ in longest)} functions over {LONG} lines")


if __name__ == "__main__":
    main()
