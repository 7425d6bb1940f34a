"""What a user can mend in a calibration."""

from wheelhop.files import InputError


class CalibrationError(InputError):
    """Constants that do not fit, or a session that cannot be evaluated."""
