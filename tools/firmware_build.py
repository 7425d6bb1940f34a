"""Build the firmware offline, from Debian's avr-gcc and Arduino core, as platformio.ini says.

    python3 tools/firmware_build.py [nano] [mega]

makes build/firmware/ENV/firmware.elf and .hex. Sources, flags and boards are read from
platformio.ini; only what PlatformIO's platform adds by itself is repeated here.
"""

import configparser
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CORE = Path("/usr/share/arduino/hardware/arduino/avr")

# PlatformIO's boards: controller, variant of the Arduino core, macro.
BOARDS = {
    "nanoatmega328new": ("atmega328p", "eightanaloginputs", "ARDUINO_AVR_NANO"),
    "megaatmega2560": ("atmega2560", "mega", "ARDUINO_AVR_MEGA2560"),
}
FLASH = {"atmega328p": 30720, "atmega2560": 253952}  # bytes, without the boot loader
RAM = {"atmega328p": 2048, "atmega2560": 8192}

# What PlatformIO's platform atmelavr passes for every Arduino project.
COMMON = "-Os -Wall -ffunction-sections -fdata-sections -flto -DF_CPU=16000000L -DARDUINO=10808"
COMMON += " -DARDUINO_ARCH_AVR"
C_ONLY = "-std=gnu11 -fno-fat-lto-objects"
CPP_ONLY = "-fno-exceptions -fno-threadsafe-statics -fpermissive -std=gnu++11"
CPP_ONLY += " -Wno-error=narrowing"
CODE = {".c", ".cpp", ".S"}
LINK = "-Os -flto -Wl,--gc-sections -Wl,--relax -fuse-linker-plugin"


class BuildError(Exception):
    """Something that the user can mend, in one line."""


def read_ini() -> configparser.ConfigParser:
    """Return platformio.ini with its references resolved."""
    ini = configparser.ConfigParser(interpolation=configparser.ExtendedInterpolation())
    text = (ROOT / "platformio.ini").read_text(encoding="utf-8")
    ini.read_string(re.sub(r"\$\{(\w+)\.build_flags\}", r"${\1:build_flags}", text))
    return ini


def option(ini: configparser.ConfigParser, env: str, key: str) -> str:
    """Return an option of an environment, inherited as PlatformIO does."""
    section = f"env:{env}"
    for place in (section, ini.get(section, "extends", fallback=""), "env"):
        if place and ini.has_option(place, key):
            return ini.get(place, key)
    raise BuildError(f"platformio.ini: [{section}] has no {key}")


@dataclass(frozen=True)
class Sources:
    """The firmware's own source files, FatFs's among them, and the folders of its parts."""

    main: list[Path]
    parts: list[Path]
    folders: list[Path]


def sources(ini: configparser.ConfigParser) -> Sources:
    """Find what platformio.ini points to."""
    project = ini["platformio"]
    places = (project["lib_dir"], ini["env"]["lib_extra_dirs"])
    folders = [f for place in places for f in sorted((ROOT / place).iterdir()) if f.is_dir()]
    main = sorted((ROOT / project["src_dir"]).glob("*.cpp"))
    return Sources(main, [p for f in folders for p in sorted(f.glob("*.c*"))], folders)


def core_sources() -> list[Path]:
    """Find the sources of the Arduino core."""
    return [path for path in sorted((CORE / "cores/arduino").iterdir()) if path.suffix in CODE]


def compiler_flags(ini: configparser.ConfigParser, env: str) -> list[str]:
    """Return the flags that C and C++ have in common."""
    mcu, _, macro = BOARDS[option(ini, env, "board")]
    flags = [f"-mmcu={mcu}", *shlex.split(COMMON), f"-D{macro}", "-DPLATFORMIO"]
    return flags + shlex.split(option(ini, env, "build_flags"))


def native_command(tests: Path, target: Path) -> list[str]:
    """Return the command that compiles all parts with the tests in a folder into one program."""
    ini = read_ini()
    ours = sources(ini)
    flags = shlex.split(option(ini, "native", "build_flags"))
    include = [f"-I{folder}" for folder in ours.folders]
    files = [*ours.parts, *sorted(tests.glob("*.cpp"))]
    return ["g++", "-g", *flags, *include, *map(str, files), "-o", str(target)]


def compile_one(source: Path, target: Path, flags: list[str], includes: list[str]) -> Path:
    """Compile a source file and return the object file."""
    if source.suffix == ".cpp":
        command = ["avr-g++", *shlex.split(CPP_ONLY)]
    elif source.suffix == ".c":
        command = ["avr-gcc", *shlex.split(C_ONLY)]
    else:
        command = ["avr-gcc", "-x", "assembler-with-cpp"]
    ours = source.is_relative_to(ROOT / "firmware") and "foreign" not in source.parts
    quiet = [] if ours else ["-w"]
    subprocess.run(
        [*command, *flags, *quiet, *includes, "-c", str(source), "-o", str(target)], check=True
    )
    return target


def is_fresh(target: Path) -> bool:
    """Tell whether nothing that a file is made from is newer than it."""
    if not target.exists():
        return False
    inputs = [ROOT / "platformio.ini", Path(__file__)]
    inputs += [path for path in (ROOT / "firmware").rglob("*") if path.suffix in CODE | {".h"}]
    return all(path.stat().st_mtime < target.stat().st_mtime for path in inputs)


def build(ini: configparser.ConfigParser, env: str) -> Path:
    """Build one environment, if something has changed, and return the ELF file."""
    elf = ROOT / "build/firmware" / env / "firmware.elf"
    if is_fresh(elf.with_suffix(".hex")):
        return elf
    mcu, variant, _ = BOARDS[option(ini, env, "board")]
    flags = compiler_flags(ini, env)
    ours = sources(ini)
    core = core_sources()
    folders = [CORE / "cores/arduino", CORE / "variants" / variant, *ours.folders]
    includes = [f"-I{folder}" for folder in folders]
    elf.parent.mkdir(parents=True, exist_ok=True)
    # What others may be using is replaced whole at the end.
    with tempfile.TemporaryDirectory(dir=elf.parent) as name:
        made = Path(name)

        def compiled(path: Path) -> str:
            target = made / f"{path.parent.name}-{path.name}.o"
            return str(compile_one(path, target, flags, includes))

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            objects = list(pool.map(compiled, [*ours.main, *ours.parts]))
            core_objects = list(pool.map(compiled, core))
        archive = str(made / "core.a")
        subprocess.run(["avr-gcc-ar", "rcs", archive, *core_objects], check=True)
        new = made / "firmware.elf"
        link = [
            "avr-gcc",
            f"-mmcu={mcu}",
            *shlex.split(LINK),
            "-o",
            str(new),
            *objects,
            archive,
            "-lm",
        ]
        subprocess.run(link, check=True)
        hexadecimal = ["-O", "ihex", "-R", ".eeprom", str(new), str(new.with_suffix(".hex"))]
        subprocess.run(["avr-objcopy", *hexadecimal], check=True)
        new.replace(elf)
        new.with_suffix(".hex").replace(elf.with_suffix(".hex"))
    return elf


def main(envs: list[str]) -> int:
    """Build the environments named, or the default ones; return the exit status."""
    try:
        for tool in ("avr-g++", "avr-objcopy"):
            if not shutil.which(tool):
                raise BuildError(
                    f"{tool} is missing: apt-get install gcc-avr avr-libc binutils-avr"
                )
        if not CORE.exists():
            raise BuildError(f"{CORE} is missing: apt-get install arduino-core-avr")
        ini = read_ini()
        for env in envs or ini["platformio"]["default_envs"].replace(",", " ").split():
            if not ini.has_section(f"env:{env}") or not ini.has_option(f"env:{env}", "board"):
                raise BuildError(f"platformio.ini has no board for {env}")
            print(build(ini, env).relative_to(ROOT))
    except BuildError as error:
        print(f"build_firmware: {error}", file=sys.stderr)
        return 2
    except subprocess.CalledProcessError as error:
        print(f"build_firmware: {Path(error.cmd[0]).name} failed", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
