"""What is public: documented, loaded when it is used, renamed only with a warning."""

import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import wheelhop
import wheelhop as wh

PAGE = (Path(__file__).parents[2] / "docs/python.md").read_text(encoding="utf-8")
HEAVY = ("numpy", "scipy", "numba", "pandas", "pyarrow", "matplotlib", "rich", "nicegui")


def loaded_after(code):
    """Which of the heavy packages a fresh interpreter has loaded."""
    code += f"\nimport sys; print([name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()[-1]


def test_all_that_is_public_is_on_the_page_and_nothing_else():
    sections = re.split(r"^## ", PAGE, flags=re.M)
    named = [
        name
        for section in sections
        for name in re.findall(r"^\| `(\w+)` \|", section, re.M)
        if section.startswith(("Read", "Ask", "Make", "Types"))
    ]
    assert sorted(named) == sorted(wh.__all__)
    assert len(set(named)) == len(named)
    assert dir(wh) == sorted(wh.__all__)


@pytest.mark.parametrize("name", [name for name in wh.__all__ if name != "__version__"])
def test_every_public_name_says_what_it_is(name):
    value = getattr(wh, name)
    assert inspect.getdoc(value), name
    members = inspect.getmembers(value) if isinstance(value, type) else []
    for member, what in members:
        of_ours = getattr(inspect.unwrap(getattr(what, "fget", what)), "__module__", "") or ""
        if not member.startswith("_") and of_ours.startswith("wheelhop"):
            assert inspect.getdoc(what), f"{name}.{member}"


FUNCTIONS = [name for name in wh.__all__ if inspect.isfunction(getattr(wh, name))]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_public_function_says_what_it_takes_gives_and_raises(name):
    """In numpydoc's sections: every parameter by its name, and what comes back, if anything."""
    function = getattr(wh, name)
    parts = re.split(r"^(\w+)\n-{3,}$", inspect.getdoc(function), flags=re.M)
    sections = dict(zip(parts[1::2], parts[2::2], strict=True))
    signature = inspect.signature(function)
    heads = re.findall(r"^(\S.*?)(?: :.*)?$", sections["Parameters"], re.M)
    named = [name.lstrip("*") for head in heads for name in re.split(r",\s*", head)]
    assert sorted(named) == sorted(signature.parameters)
    assert "Raises" in sections
    assert signature.return_annotation in (None, "None") or "Returns" in sections


def test_methods_the_page_names_exist():
    for name in ("ladder", "parameters", "residuals", "agreement", "write_report", "write_model"):
        assert callable(getattr(wh.ComparisonResult, name))
        assert callable(getattr(wh.DiagnosisResult, name))
        assert f"`{name}" in PAGE
    assert callable(wh.DiagnosisResult.ranking) and callable(wh.ComparisonResult.with_values)


def test_importing_the_package_and_asking_for_help_load_nothing_heavy():
    assert loaded_after("import wheelhop") == "[]"
    asked = "from wheelhop.cli.main import main\ntry: main(['--help'])\nexcept SystemExit: pass"
    assert loaded_after(asked) == "[]"


def test_reading_a_campaign_loads_no_tables_and_no_figures():
    example = str(Path(__file__).parents[2] / "examples/clean")
    after = loaded_after(f"import wheelhop as wh; print(wh.read({example!r}))")
    assert not {"pandas", "matplotlib", "nicegui"} & set(re.findall(r"\w+", after))


@pytest.mark.parametrize("name", ["compare", "diagnose", "export", "predict", "simulate", "tune"])
def test_a_verb_stays_a_function_when_the_package_of_its_name_is_imported(name):
    code = f"""
import inspect, pickle
import wheelhop as wh
import wheelhop.{name}
from wheelhop.{name} import *
import wheelhop.api as verbs
assert inspect.isfunction(wh.{name}) and wh.{name} is verbs.{name}
assert pickle.loads(pickle.dumps(wh.{name})) is wh.{name}
"""
    assert loaded_after(code)


def test_the_three_folders_are_one_package():
    for room in ("campaign", "calibration", "hil_sim"):
        assert inspect.ismodule(getattr(wheelhop, room))
    assert re.fullmatch(r"\d+\.\d+\.\d+.*", wh.__version__)


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'diagnos'"):
        _ = wh.diagnos
    with pytest.raises(ImportError):
        from wheelhop import nothing_of_this_name  # noqa: F401


def test_a_name_of_before_still_works_and_says_what_to_write(monkeypatch):
    monkeypatch.setattr(wh, "_RENAMED", {"read_campaign": "read"})
    with pytest.warns(DeprecationWarning, match=r"wheelhop\.read_campaign is now wheelhop\.read"):
        assert wh.read_campaign is wh.read
