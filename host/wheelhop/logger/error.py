"""What goes wrong between host and logger."""

from wheelhop.files import InputError


class LoggerError(InputError):
    """The logger, its files or the line to it."""
