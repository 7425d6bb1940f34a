"""Files that people write: read strictly, every mistake one line that says where and what to do."""

from wheelhop.files.error import InputError
from wheelhop.files.keys import Table, did_you_mean, read_text, read_toml, shown, similar_file

__all__ = [
    "InputError",
    "Table",
    "did_you_mean",
    "read_text",
    "read_toml",
    "shown",
    "similar_file",
]
