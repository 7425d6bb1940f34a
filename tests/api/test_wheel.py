"""What a user installs: the wheel and the sdist hold the whole package, and it works alone."""

import io
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

TRY = """
import sys
place = sys.argv[1]
sys.path[:] = [place, *(p for p in sys.path if not p.startswith(sys.argv[2]) or ".venv" in p)]
sys.path_importer_cache.clear()
import wheelhop as wh
from importlib import import_module
for room in sys.argv[3:]:
    assert import_module(f"wheelhop.{room}").__file__.startswith(place), room
from wheelhop.compare import Comparison
assert Comparison is wh.Comparison and callable(wh.compare) and wh.load_effects()
print(wh.read(f"{sys.argv[2]}/examples/clean"))
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The names in the sdist, and the wheel that was made from it, unpacked."""
    pytest.importorskip("hatchling")
    out = tmp_path_factory.mktemp("dist")
    build(ROOT, "sdist", out)
    with tarfile.open(next(out.glob("*.tar.gz"))) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
        sdist.extractall(out / "source", filter="data")
    build(next((out / "source").iterdir()), "wheel", out)
    with zipfile.ZipFile(next(out.glob("*.whl"))) as wheel:
        wheel.extractall(out / "wheel")
    return names, out / "wheel"


def build(source, target, out):
    command = [sys.executable, "-m", "hatchling", "build", "--target", target, "-d", str(out)]
    done = subprocess.run(command, cwd=source, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="a copy without its history")
def test_the_version_is_that_of_the_tag_where_one_is_known(tmp_path):
    """A copy that knows of none claims no release: neither a git archive nor a plain one."""
    pytest.importorskip("hatch_vcs")
    papers = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    fallback = papers["tool"]["hatch"]["version"]["fallback-version"]
    clone = tmp_path / "clone"
    subprocess.run(["git", "clone", "-q", "--no-tags", str(ROOT), str(clone)], check=True)
    assert version_of(archive(clone, tmp_path / "untagged")) == fallback
    subprocess.run(["git", "tag", "v7.8.9"], cwd=clone, check=True)
    assert version_of(clone) == "7.8.9"
    assert version_of(archive(clone, tmp_path / "tagged")) == "7.8.9"
    shutil.rmtree(clone / ".git")
    assert version_of(clone) == fallback


def archive(clone, folder):
    tar = subprocess.run(["git", "archive", "HEAD"], cwd=clone, capture_output=True, check=True)
    with tarfile.open(fileobj=io.BytesIO(tar.stdout)) as files:
        files.extractall(folder, filter="data")
    return folder


def version_of(folder):
    command = [sys.executable, "-m", "hatchling", "version"]
    told = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    return told.stdout.strip()


def files_in_the_repository():
    for portion in ("host", "calibration", "hil_sim"):
        folder = ROOT / portion
        for path in folder.rglob("*"):
            if path.suffix in {".py", ".css", ".html", ".toml", ".typed"}:
                yield path.relative_to(folder)


def test_the_wheel_holds_every_module_style_and_table_once(built):
    _, wheel = built
    there = {path.relative_to(wheel) for path in wheel.rglob("*") if path.is_file()}
    ours = {path for path in files_in_the_repository() if path.name != "truth.toml"}
    missing = {path for path in ours if path.parts[0] == "wheelhop"} - there
    assert missing == set()
    assert Path("wheelhop/py.typed") in there
    assert {"LICENSE", "FatFs.txt", "LGPL-2.1.txt"} <= {
        path.name for path in there if path.parts[0].endswith(".dist-info")
    }
    assert not [path for path in there if path.name == "truth.toml" or path.parts[0] == "tests"]
    assert len([p for p in there if p.parts[:3] == ("wheelhop", "workbench", "gallery")]) > 20


def test_the_sdist_holds_what_the_tests_and_the_reader_need(built):
    names, _ = built
    for name in ("README.md", "LICENSE", "docs/python.md", "tests/api/test_wheel.py"):
        assert name in names
    assert "licenses/FatFs.txt" in names
    assert not [name for name in names if name.startswith((".venv", ".git/"))]


def test_the_unpacked_wheel_works_by_itself(built, tmp_path):
    _, wheel = built
    rooms = sorted(path.parent.name for path in (wheel / "wheelhop").glob("*/__init__.py"))
    assert {"campaign", "calibration", "hil_sim", "api"} <= set(rooms)
    command = [sys.executable, "-c", TRY, str(wheel), str(ROOT), *rooms]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "<Campaign 'Open campaign: clean'" in done.stdout
