"""The data logger as the host sees it: writing its firmware."""

from wheelhop.logger.error import LoggerError
from wheelhop.logger.flash import Upload, plan_upload, upload

__all__ = ["LoggerError", "Upload", "plan_upload", "upload"]
