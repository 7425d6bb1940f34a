"""Build script of the offline platform native: this computer's own compiler."""

from SCons.Script import Default, DefaultEnvironment

Default(DefaultEnvironment().BuildProgram())
