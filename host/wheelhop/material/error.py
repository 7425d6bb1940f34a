"""What a user of rig data or of a specimen's file can mend."""

from wheelhop.files import InputError


class MaterialError(InputError):
    """A mistake in rig data or in a specimen; ``str(error)`` is one line."""
