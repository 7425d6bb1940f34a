"""The Arduino core as the offline platform's framework, run by PlatformIO's SCons."""

from pathlib import Path

from SCons.Script import DefaultEnvironment

env = DefaultEnvironment()
core = Path(env.PioPlatform().get_package_dir("framework-arduino-avr"))
variant = env.BoardConfig().get("build.variant")
env.Append(CPPPATH=[str(core / "cores/arduino"), str(core / "variants" / variant)])
env.Prepend(LIBS=[env.BuildLibrary("$BUILD_DIR/core", str(core / "cores/arduino"))])
