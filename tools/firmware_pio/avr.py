"""Build script of the offline platform atmelavr, run by PlatformIO's SCons.

Compilers and flags are those of tools/firmware_build.py; PlatformIO adds those of platformio.ini.
"""

import shlex
import sys

from SCons.Script import Builder, Default, DefaultEnvironment

env = DefaultEnvironment()
sys.path.insert(0, env.subst("$PROJECT_DIR/tools"))
import firmware_build as build  # noqa: E402

mcu, _, macro = build.BOARDS[env["BOARD"]]
chip = f"-mmcu={mcu}"
env.Replace(
    AR="avr-gcc-ar",
    AS="avr-gcc",
    CC="avr-gcc",
    CXX="avr-g++",
    RANLIB="avr-gcc-ranlib",
    SIZETOOL="avr-size",
    PROGNAME="firmware",
    PROGSUFFIX=".elf",
    ASPPFLAGS=[chip, "-x", "assembler-with-cpp"],
    CFLAGS=shlex.split(build.C_ONLY),
    CXXFLAGS=shlex.split(build.CPP_ONLY),
    CCFLAGS=[chip],
    CPPDEFINES=[macro],
    LINKFLAGS=[chip, *shlex.split(build.LINK)],
    LIBS=["m"],
)
env.ProcessFlags(build.COMMON)
to_hex = Builder(
    action="avr-objcopy -O ihex -R .eeprom $SOURCES $TARGET", suffix=".hex", src_suffix=".elf"
)
env.Append(BUILDERS={"Hex": to_hex})
Default(env.Hex("$BUILD_DIR/firmware", env.BuildProgram()))
