"""What a user of frame files can mend."""

from wheelhop.files import InputError


class FrameError(InputError):
    """A mistake in a frame's file; ``str(error)`` is one line."""
