"""Trouble that may pass, told from what is wrong for good."""

from __future__ import annotations

import errno

from wheelhop.campaign import CampaignError
from wheelhop.files import InputError

OF_THE_FILE = frozenset(
    (errno.ENOENT, errno.EISDIR, errno.ENOTDIR, errno.EINVAL, errno.ELOOP, errno.ENAMETOOLONG)
)
"""What the system says of a file itself; everything else (a disk, a network, rights) may pass."""


class Trouble(CampaignError):
    """A computer could not do what it was asked: nothing is known of the result."""


def lasting(error: Exception, place: str) -> str:
    """What is wrong, in one line; `place` is where, unless the error says. Raises Trouble for what
    may be gone the next time: too little memory, and what the system refuses."""
    line = str(error)
    if not isinstance(error, InputError):
        line = f"{place}: {type(error).__name__}: {error}"
    cause: BaseException | None = error
    while cause is not None:
        refused = isinstance(cause, OSError) and cause.errno not in (None, *OF_THE_FILE)
        if refused or isinstance(cause, MemoryError):
            raise Trouble(line) from error
        cause = cause.__cause__ or cause.__context__
    return line
