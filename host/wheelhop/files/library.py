"""Libraries that only some of wheelhop needs."""

from __future__ import annotations

from importlib.util import find_spec

from wheelhop.files.error import InputError


def require(package: str, what: str, extra: str, kind: type[InputError] = InputError) -> None:
    """Make sure that a package is installed before it is imported.

    Parameters
    ----------
    package
        Its name, as it is imported.
    what
        What needs it: the line begins with this.
    extra
        The extra of wheelhop that brings it.
    kind
        What is raised.

    Raises
    ------
    InputError
        It is not installed; with the command that installs it.
    """
    if find_spec(package) is None:
        raise kind(f"{what} needs {package}: pip install 'wheelhop[{extra}]'")
