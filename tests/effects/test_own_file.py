"""Of a user's file the text that was read is what runs, here and in every worker."""

import inspect
import os
import py_compile
import subprocess
import sys
import traceback
from pathlib import Path

import numpy as np
import pytest

from tests.effects.test_library import USERS
from wheelhop.campaign import CampaignError
from wheelhop.effects import load_effects
from wheelhop.effects.own_file import effects_in, read_source
from wheelhop.files import InputError
from wheelhop.predict.sweep import Axis, Sweep
from wheelhop.predict.workers import workers
from wheelhop.simulate.laws import addresses, remembers
from wheelhop.vehicle import read_vehicle

ROOT = Path(__file__).parents[2]
ZERO = np.zeros(1)


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "wheelhop"


def law_of(effect):
    return vars(sys.modules[type(effect).__module__])["quintic"]


def below(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def with_hostile_bytecode(file: Path, marker: Path) -> None:
    """Bytecode that Python takes for the file's without looking, as a zipped campaign may hold."""
    harmless = file.read_text()
    file.write_text(f"open({str(marker)!r}, 'w').close()\n" + harmless)
    py_compile.compile(
        str(file), invalidation_mode=py_compile.PycInvalidationMode.UNCHECKED_HASH, doraise=True
    )
    file.write_text(harmless)
    marker.unlink(missing_ok=True)


def test_bytecode_beside_the_file_is_not_run(tmp_path):
    file, marker = tmp_path / "mine.py", tmp_path / "was-run"
    file.write_text(USERS)
    with_hostile_bytecode(file, marker)
    assert "quintic-spring" in load_effects(file)
    assert not marker.exists()


def test_bytecode_beside_the_file_is_not_run_by_a_command(tmp_path):
    file, marker = tmp_path / "mine.py", tmp_path / "was-run"
    file.write_text(USERS)
    with_hostile_bytecode(file, marker)
    words = ["modes", str(ROOT / "examples/clean/vehicle.toml"), "--library", str(file)]
    command = [sys.executable, "-m", "wheelhop.cli.main", *words]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not marker.exists()


def test_nothing_is_read_from_or_left_beside_the_file(tmp_path, cache):
    """numba's cache is pickles, which run what they hold."""
    folder = tmp_path / "campaign"
    folder.mkdir()
    (folder / "mine.py").write_text(USERS)
    effect = load_effects(folder / "mine.py")["quintic-spring"]
    addresses((law_of(effect),))
    assert below(folder) == ["mine.py"]
    digest = read_source(folder / "mine.py").digest
    kept = below(cache / "laws" / digest)
    assert [name.split(".")[0] for name in kept] == ["mine"] * 4  # law and loop: index and code
    if sys.platform != "win32":
        assert (cache / "laws").stat().st_mode & 0o077 == 0


def test_a_cache_that_others_may_write_into_is_refused(tmp_path, cache):
    (tmp_path / "mine.py").write_text(USERS)
    (cache / "laws").mkdir(parents=True)
    (cache / "laws").chmod(0o777)
    with pytest.raises(CampaignError, match=r"laws: is not a folder that only you may enter"):
        load_effects(tmp_path / "mine.py")


def test_a_compiled_law_is_kept_for_its_text_alone(tmp_path):
    """The second text differs from the first in a number only, and is as long and as old."""
    file, hits = tmp_path / "mine.py", []
    for text in (USERS, USERS.replace("x**5", "x**3"), USERS):
        file.write_text(text)
        os.utime(file, (1_000_000_000, 1_000_000_000))
        law = law_of(load_effects(file)["quintic-spring"])
        hits.append(sum(law.stats.cache_hits.values()))
        force, _ = law(2.0, 0.0, 0.0, 0.0, 0.0, np.ones(1))
        assert force == (8.0 if "x**3" in text else 32.0)
    assert hits == [0, 0, 1]


def test_the_text_that_was_read_runs_whatever_becomes_of_the_file(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(USERS)
    source = read_source(file)
    file.write_text(USERS.replace("p[0] * x**5", "p[0] * 7.0").replace("fifth order", "no order"))
    law = law_of(load_effects(source)["quintic-spring"])
    assert law(2.0, 0.0, 0.0, 0.0, 0.0, np.ones(1))[0] == 32.0
    assert not remembers(law)  # which is read from the law's text
    assert "fifth order" in inspect.getsource(sys.modules[law.py_func.__module__])
    file.unlink()
    assert load_effects(source)["quintic-spring"].title == "a spring of the fifth order"


def test_tracebacks_show_the_lines_of_the_users_file(tmp_path):
    file = tmp_path / "mine.py"
    number = USERS[: USERS.index("return (Amplitude")].count("\n") + 1
    file.write_text(USERS.replace("return (Amplitude", "raise KeyError; return (Amplitude"))
    effect = load_effects(file)["quintic-spring"]
    with pytest.raises(KeyError) as caught:
        effect.parameters_for(None, ())
    last = traceback.extract_tb(caught.value.__traceback__)[-1]
    assert (last.filename, last.lineno) == (str(file), number)
    assert last.line.startswith("raise KeyError")


def test_a_coding_line_does_not_make_the_text_another(tmp_path):
    """In UTF-7 "+AAo-" is the end of a line: a comment here, a statement there."""
    file, marker = tmp_path / "mine.py", tmp_path / "was-run"
    file.write_text(f"# coding: utf-7\n# +AAo-open({str(marker)!r}, 'w')\n{USERS}")
    load_effects(file)
    assert not marker.exists()


def sweep_of(library) -> Sweep:
    axes = (Axis("quintic-spring.rate_N_m5", (1e9, 1e10)),)
    vehicle = read_vehicle(ROOT / "examples/clean/vehicle.toml")
    words = ("quintic-spring",)
    return Sweep(vehicle, ("washboard/low",), (10.0,), words, axes, 2.0, 1, library)


def test_workers_run_the_text_they_are_sent(tmp_path):
    """The file is gone, and a hostile one is in its place, when the processes begin."""
    file, marker = tmp_path / "mine.py", tmp_path / "was-run"
    file.write_text(USERS)
    sweep = sweep_of(read_source(file))
    here = sweep.rows(0)
    mark = sweep.fingerprint
    file.write_text(USERS + "# another\n")
    assert sweep.fingerprint == mark != sweep_of(read_source(file)).fingerprint
    file.write_text(f"open({str(marker)!r}, 'w').close()\n")
    with workers(1) as executor:
        there = executor.submit(sweep.rows, 0).result()
    assert there == here and here[0]["problem"] == ""
    assert not marker.exists()


def test_what_a_text_raises_of_its_own_names_the_file(tmp_path):
    (tmp_path / "mine.py").write_text("x = 1\n\x00")
    with pytest.raises(InputError, match=r"mine\.py: byte 6 is zero"):
        effects_in(read_source(tmp_path / "mine.py"))
