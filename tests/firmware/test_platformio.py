"""PlatformIO, with platformio.ini as it is, makes of the sources what tools/firmware_build.py does.

It works offline here, on the packages of tools/pio_offline.py.
"""

import json
import shlex
import subprocess
import sys

import pytest

from tests.firmware.promises.conftest import built
from tests.firmware.promises.logger import Logger, configure
from tools import firmware_build
from tools.firmware_build import ROOT
from wheelhop.hil_sim import CardImage, ramp

pytest.importorskip("platformio", reason="platformio is missing: pip install platformio")
pytest.importorskip("SCons", reason="SCons is missing: pip install scons")


@pytest.fixture
def pio(tmp_path, monkeypatch):
    """A function that runs PlatformIO in folders of its own and returns what it printed."""
    monkeypatch.syspath_prepend(ROOT / "tools")
    import pio_offline

    try:
        environment = pio_offline.prepare(tmp_path / "core")
    except pio_offline.build.BuildError as error:
        pytest.skip(str(error))
    environment["PLATFORMIO_WORKSPACE_DIR"] = str(tmp_path / "workspace")

    def run(*words):
        command = [sys.executable, "-m", "platformio", *words]
        done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-4000:]
        return done.stdout

    return run


def test_the_ini_has_no_faults_and_is_read_the_same(pio):
    assert "free from linting errors" in pio("project", "config", "--lint")
    sections = {
        name: dict(options)
        for name, options in json.loads(pio("project", "config", "--json-output"))
    }
    ini = firmware_build.read_ini()
    for env in ("nano", "mega", "native"):
        theirs = sections[f"env:{env}"]
        ours = shlex.split(firmware_build.option(ini, env, "build_flags"))
        assert shlex.split(" ".join(theirs["build_flags"])) == ours
        if env != "native":
            assert theirs["board"] == firmware_build.option(ini, env, "board")
            assert theirs["board"] in firmware_build.BOARDS


def compiled(output):
    """Source and flags of every compilation that PlatformIO printed, and the flags of the link."""
    link, sources = [], {}
    for words in map(shlex.split, output.splitlines()):
        if words and words[0] in ("avr-gcc", "avr-g++"):
            flags = sorted(plain(words[1:]))
            if "-c" in words:
                sources[(ROOT / words[-1]).resolve()] = flags
            else:
                link = flags
    return sources, link


def plain(words):
    """Flags without file names, folders, and the version of PlatformIO."""
    for word in words:
        if word.startswith("-") and word[:2] not in ("-I", "-o", "-c", "-L", "-l"):
            yield word.partition("=")[0] if word.startswith("-DPLATFORMIO") else word


@pytest.mark.parametrize("env", ["nano", "mega"])
def test_sources_and_flags_are_the_same(pio, env):
    sources, link = compiled(pio("run", "-e", env, "-v"))
    ini = firmware_build.read_ini()
    ours = firmware_build.sources(ini)
    core = firmware_build.core_sources()
    assert set(sources) == {path.resolve() for path in (*ours.main, *ours.parts, *core)}
    common = firmware_build.compiler_flags(ini, env)
    only = {".c": firmware_build.C_ONLY, ".cpp": firmware_build.CPP_ONLY}
    for path, flags in sources.items():
        if path.suffix in only:
            assert flags == sorted(plain([*common, *shlex.split(only[path.suffix])])), path
    chip = next(flag for flag in common if flag.startswith("-mmcu="))
    group = ["-Wl,--start-group", "-Wl,--end-group"]
    assert link == sorted([chip, *shlex.split(firmware_build.LINK), *group])


def test_its_firmware_records_a_session(pio, tmp_path):
    built("nano", tmp_path)  # skips where there is no simulated board
    pio("run", "-e", "nano")
    card = configure(CardImage.fat32(tmp_path / "card.img"), "size_mb = 1\n")
    elf = tmp_path / "workspace/build/nano/firmware.elf"
    with Logger(elf, card, signals=ramp(100, 10)) as one:
        one.boot()
        assert one.command("start").ok
        one.run(3.0)
        assert one.command("stop").ok
        log = one.log()
    assert len(log.scans) >= 299 and log.summary["lost"] == "0"
    assert elf.with_suffix(".hex").read_text().endswith(":00000001FF\n")


@pytest.mark.slow  # test_native.py runs them, too
def test_it_runs_the_native_tests(pio):
    assert "native:test_parts [PASSED]" in pio("test", "-e", "native")
