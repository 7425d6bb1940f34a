"""The rules of the house: arrows go one way, files stay small, nothing is left half done."""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PORTIONS = [ROOT / name / "wheelhop" for name in ("host", "calibration", "hil_sim")]
# A package may import itself and the packages before it.
PACKAGES = (
    *("files", "logger", "formats", "calibration", "campaign", "track"),
    *("material", "frame", "vehicle", "effects", "simulate", "compare", "gate", "fit", "identify"),
    *("diagnose", "law", "hil_sim", "predict", "tune", "export"),
    *("report", "api", "workbench", "cli"),
)
DOOR = ROOT / "host/wheelhop/__init__.py"  # loads packages when they are asked for
# A method that users call may hand over to a later package, when it is called.
HANDS_OVER = {("logger/recording.py", "formats")}
LONGEST_FILE = 400  # lines
WRITES = {"savefig", "savemat", "savetxt", "write_text", "write_bytes", "write_table", "to_parquet"}
# What does not write into the draft that `files.replacing` gives, and why nothing is lost by it.
OWN_WAY = {
    "files": "here it is done",
    "hil_sim": "the card of an emulated logger",
    "campaign/write.py": "is handed the draft",
    "formats/own_csv.py": "is handed the draft",
    "formats/parquet.py": "is handed the draft",
    "formats/uff.py": "is handed the draft",
    "predict/journal.py": "a journal grows line by line",
    "report/svg.py": "in memory",
    "track/rdf.py": "into a draft that is open",
    "workbench/draft.py": "in a temporary folder",
    "workbench/export.py": "in memory, then a draft",
    "workbench/recorder.py": "to where nothing is kept",
}
READS = {"read_bytes", "read_text", "read_table", "read_schema", "ParquetFile", "loadtxt"}
# What does not read by `files.read_text` and the like, and why it is plain and fits all the same.
READ_OWN_WAY = {
    "files": "here it is done",
    "hil_sim": "the files of an emulated logger",
    "campaign/proving_ground.py": "of the package",
    "campaign/recordings.py": "weighed and refused just before",
    "formats/bags.py": "the registry refuses, and it is weighed before",
    "formats/bulk.py": "in pieces, and refused just before",
    "formats/cells.py": "both ends, and refused just before",
    "formats/header.py": "in pieces, and refused just before",
    "formats/matlab.py": "first bytes, after the registry refused",
    "formats/mdf.py": "the registry refuses, and it is weighed when open",
    "formats/parquet.py": "weighs by what the file says",
    "formats/registry.py": "the header that it has just written, and first bytes",
    "formats/uff.py": "in a temporary folder",
    "logger/download.py": "what it has just written",
    "logger/emulated.py": "of the user's own cache",
    "logger/live.py": "of the package",
    "logger/recovery.py": "in pieces, after the survey refused",
    "logger/survey.py": "in pieces",
    "export/fmu.py": "of the package",
    "predict/identity.py": "of the package",
    "report": "of the package, or what was just printed",
    "workbench/app.py": "of the package",
    "workbench/sessions.py": "a picture that it has drawn",
    "workbench/theme.py": "of the package",
}
TEXT = {".py", ".toml", ".md", ".sh", ".html", ".css", ".js", ".cpp", ".h", ".yml", ".yaml", ""}
FOLDERS = ("host", "calibration", "hil_sim", "firmware", "tests", "benchmarks", "docs", "tools")

MODULES = sorted(path for portion in PORTIONS for path in portion.rglob("*.py"))


def texts() -> Iterator[Path]:
    """Every text file of ours; recordings, others' sources and what tools leave behind are not."""
    top = [path for path in ROOT.iterdir() if path.is_file()]
    below = [path for name in (*FOLDERS, ".ci", "examples") for path in (ROOT / name).rglob("*")]
    for path in (*top, *below):
        hidden = any(
            part.startswith(".") and part != ".ci" for part in path.relative_to(ROOT).parts
        )
        foreign = path.is_relative_to(ROOT / "firmware/foreign")
        if (
            path.is_file()
            and path.suffix in TEXT
            and not (hidden or foreign or path.name == "LICENSE")
        ):
            yield path


def imported_packages(path: Path) -> Iterator[tuple[int, str]]:
    """Line and package of every import of wheelhop in a module, wherever it stands."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: write imports in full"
            names = [node.module or ""]
            if node.module == "wheelhop":
                names = [f"wheelhop.{alias.name}" for alias in node.names]
        for name in names:
            if name.startswith("wheelhop."):
                yield node.lineno, name.split(".")[1]
            assert name != "wheelhop", f"{path}:{node.lineno}: import the package itself"


@pytest.mark.parametrize(
    "path", [m for m in MODULES if m != DOOR], ids=lambda path: str(path.relative_to(ROOT))
)
def test_imports_only_go_upstream(path):
    package = next(path.relative_to(p).parts[0] for p in PORTIONS if path.is_relative_to(p))
    assert package in PACKAGES, f"{package} has no place in the order of the packages"
    for line, other in imported_packages(path):
        if ("/".join(path.parts[-2:]), other) in HANDS_OVER:
            continue
        assert other in PACKAGES and PACKAGES.index(other) <= PACKAGES.index(package), (
            f"{path.relative_to(ROOT)}:{line}: {package} must not import {other}"
        )


def test_the_portions_form_one_package_with_one_door():
    assert [path for p in PORTIONS if (path := p / "__init__.py").exists()] == [DOOR]
    packages = {path.parent for path in MODULES}
    assert [package for package in packages if not (package / "__init__.py").exists()] == []


def writes(path: Path) -> Iterator[str]:
    """Every call in a module that writes a file by its name, unless that is a draft's."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)):
            continue
        names = {arg.value for arg in node.args if isinstance(arg, ast.Constant)}
        opens = node.func.attr == "open" and names & {"w", "wb", "a", "ab", "r+b", "w+b", "x", "xb"}
        given = [node.func.value, *node.args[:1]]
        if (node.func.attr in WRITES or opens) and not any(
            isinstance(part, ast.Name) and part.id == "draft" for part in given
        ):
            yield f"{path.relative_to(ROOT)}:{node.lineno}: {ast.unparse(node)[:60]}"


def test_files_are_written_whole_or_not_at_all():
    """Through `files.replacing`, or for a reason that is given."""
    found = {
        path: list(writes(path))
        for portion in PORTIONS
        for path in portion.rglob("*.py")
        if not {path.relative_to(portion).parts[0], path.relative_to(portion).as_posix()}
        & set(OWN_WAY)
    }
    assert [line for lines in found.values() for line in lines] == []


def reads(path: Path) -> Iterator[str]:
    """Every call of a method in a module that opens a file to read it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)):
            continue
        modes = {arg.value for arg in node.args if isinstance(arg, ast.Constant)}
        if node.func.attr in READS or (node.func.attr == "open" and "rb" in modes):
            yield f"{path}:{node.lineno}: {ast.unparse(node)[:60]}"


def test_files_of_people_are_read_at_one_place():
    """Which refuses what is no plain file and takes too much memory; or for a reason given."""
    known: dict[str, list[str]] = {}
    for portion in PORTIONS:
        for path in portion.rglob("*.py"):
            place = path.relative_to(portion)
            own = {place.parts[0], place.as_posix()} & set(READ_OWN_WAY)
            known.setdefault(own.pop() if own else "", []).extend(reads(path))
    assert known[""] == []
    assert sorted(place for place, lines in known.items() if place and not lines) == []
    assert set(READ_OWN_WAY) <= set(known)


def test_no_file_is_longer_than_a_few_screens():
    long = {
        str(path.relative_to(ROOT)): lines
        for path in texts()
        if path.suffix in {".py", ".cpp", ".h"}
        and (lines := len(path.read_text(encoding="utf-8").splitlines())) > LONGEST_FILE
    }
    assert long == {}


def test_nothing_is_left_half_done_and_no_path_belongs_to_one_machine():
    leftover = re.compile(r"\b(TO" r"DO|FIX" r"ME|XX" r"X)\b|(?<![\w.])/(home|wo" r"rk|Users)/\w")
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in texts()
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if leftover.search(line)
    ]
    assert found == []


def test_packages_that_compute_do_not_load_the_plotting():
    """In one interpreter: what one of them loads stays loaded for the next."""
    code = (
        "import sys\nfrom importlib import import_module\n"
        "for package in 'campaign', 'frame', 'vehicle', 'track', 'simulate', 'compare':\n"
        "    import_module(f'wheelhop.{package}')\n"
        "    assert 'matplotlib' not in sys.modules, package"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_the_architecture_page_names_every_package_in_order():
    plan = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert tuple(re.findall(r"^\| `(\w+)` \|", plan, re.M)) == PACKAGES


def test_the_plan_of_a_diagnosis_names_every_file_of_it():
    plan = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    steps = plan.split("## A diagnosis, step by step")[1].split("\n## ")[0]
    told = set(re.findall(r"`diagnose/([\w/]+\.py)`", steps))
    folder = ROOT / "host" / "wheelhop" / "diagnose"
    assert told == {f.relative_to(folder).as_posix() for f in folder.rglob("[!_]*.py")}
