"""Let PlatformIO build and test the firmware where its registry cannot be reached.

    python tools/pio_offline.py run -e nano
    python tools/pio_offline.py test -e native

runs `pio` with what follows, and platformio.ini as it is. What PlatformIO would download stands
in build/pio-core: small packages that lead to Debian's avr-gcc and Arduino core, PyPI's SCons,
and the build scripts of tools/firmware_pio. It needs, in the Python that runs it:
pip install platformio scons.
"""

import json
import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import firmware_build as build

HOME = build.ROOT / "build" / "pio-core"
SCRIPTS = build.ROOT / "tools" / "firmware_pio"
SCONS = "from SCons.Script import main\n\nmain()\n"
AVR_TOOLS = ("gcc", "g++", "gcc-ar", "gcc-ranlib", "objcopy", "size")
OWNER = "platformio"  # of the packages in whose place ours stand

Manifest = dict[str, object]


def package(folder: Path, kind: str, name: str, version: str, **more: object) -> Path:
    """Make a package's folder afresh, with its manifest and PlatformIO's note of its origin."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    about = {"name": name, "version": version}
    spec = {"owner": OWNER, "id": None, "name": name, "requirements": None, "uri": None}
    manifest = "platform.json" if kind == "platform" else "package.json"
    write(folder / manifest, {**about, "description": "for building offline", **more})
    write(folder / ".piopm", {"type": kind, **about, "spec": spec})
    return folder


def write(path: Path, content: Manifest) -> None:
    """Write JSON."""
    path.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")


def tool_scons(home: Path) -> None:
    """SCons of PyPI, under the version that this PlatformIO asks for."""
    from platformio.dependencies import get_core_dependencies

    version = get_core_dependencies()["tool-scons"].lstrip("~^=")
    folder = package(home / "packages/tool-scons", "tool", "tool-scons", version)
    (folder / "scons.py").write_text(SCONS, encoding="utf-8")


def toolchain(home: Path) -> None:
    """Links to Debian's avr-gcc."""
    name = "toolchain-atmelavr"
    folder = package(home / "packages" / name, "tool", name, "1.0.0") / "bin"
    folder.mkdir()
    for tool in AVR_TOOLS:
        path = shutil.which(f"avr-{tool}")
        if path is None:
            raise build.BuildError(f"avr-{tool} is missing: apt-get install gcc-avr avr-libc")
        (folder / f"avr-{tool}").symlink_to(path)


def framework(home: Path) -> None:
    """Links to Debian's Arduino core."""
    if not build.CORE.exists():
        raise build.BuildError(f"{build.CORE} is missing: apt-get install arduino-core-avr")
    name = "framework-arduino-avr"
    folder = package(home / "packages" / name, "tool", name, "1.0.0")
    for part in ("cores", "variants"):
        (folder / part).symlink_to(build.CORE / part)


def platform_atmelavr(home: Path) -> None:
    """The platform of both boards."""
    packages = {
        "toolchain-atmelavr": {"type": "toolchain", "owner": OWNER, "version": "*"},
        "framework-arduino-avr": {"type": "framework", "owner": OWNER, "version": "*"},
    }
    arduino = {"package": "framework-arduino-avr", "script": "builder/arduino.py"}
    folder = platform(
        home, "atmelavr", "avr.py", frameworks={"arduino": arduino}, packages=packages
    )
    (folder / "builder/arduino.py").symlink_to(SCRIPTS / "arduino.py")
    (folder / "boards").mkdir()
    for board, (mcu, variant, macro) in build.BOARDS.items():
        about: Manifest = {"name": macro, "url": "", "vendor": "Arduino", "frameworks": ["arduino"]}
        about["build"] = {"mcu": mcu, "variant": variant, "f_cpu": "16000000L"}
        about["upload"] = {"maximum_size": build.FLASH[mcu], "maximum_ram_size": build.RAM[mcu]}
        write(folder / f"boards/{board}.json", about)


def platform(home: Path, name: str, script: str, **more: object) -> Path:
    """A platform whose builder is one of ours."""
    folder = package(home / "platforms" / name, "platform", name, "1.0.0", title=name, **more)
    (folder / "builder").mkdir()
    (folder / "builder/main.py").symlink_to(SCRIPTS / script)
    return folder


def prepare(home: Path = HOME) -> dict[str, str]:
    """Make the packages in a folder; return the environment in which `pio` finds them.

    Raises BuildError where something is missing.
    """
    for module, name in (("platformio", "platformio"), ("SCons", "scons")):
        if find_spec(module) is None:
            raise build.BuildError(f"{name} is missing: {sys.executable} -m pip install {name}")
    tool_scons(home)
    toolchain(home)
    framework(home)
    platform_atmelavr(home)
    platform(home, "native", "native.py")
    here = {"PLATFORMIO_CORE_DIR": str(home), "PLATFORMIO_SETTING_ENABLE_TELEMETRY": "no"}
    return {**os.environ, **here}


def main(arguments: list[str]) -> int:
    """Prepare, and run `pio` with the arguments; return the exit status."""
    try:
        environment = prepare()
    except build.BuildError as error:
        print(f"pio_offline: {error}", file=sys.stderr)
        return 2
    pio = [sys.executable, "-m", "platformio", *arguments]
    return subprocess.run(pio, cwd=build.ROOT, env=environment).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] or ["run"]))
