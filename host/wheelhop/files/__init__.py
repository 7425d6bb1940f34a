"""Files that people write, read strictly, every mistake one line that says where and what to do;
and files written for people, whole or not at all."""

from wheelhop.files.error import InputError
from wheelhop.files.folders import cache_folder, own_folder
from wheelhop.files.keys import (
    Table,
    did_you_mean,
    parse_toml,
    read_text,
    read_toml,
    readable,
    shown,
    similar_file,
)
from wheelhop.files.library import require
from wheelhop.files.lock import claimed, locked
from wheelhop.files.process import away_from_here
from wheelhop.files.progress import Progress, Watching
from wheelhop.files.read import (
    NUMBERS,
    TABLE,
    check_plain,
    check_room,
    digest,
    read_bytes,
    read_text_and_zeros,
    read_text_bytes,
)
from wheelhop.files.source import Source
from wheelhop.files.toml import Document, dotted, to_toml
from wheelhop.files.write import (
    check_new,
    check_picture,
    check_target,
    is_draft,
    made_folder,
    make_folder,
    new_folder,
    quoted,
    remove,
    replacing,
    sync_folder,
    write_picture,
    write_text,
)

__all__ = [
    "NUMBERS",
    "TABLE",
    "Document",
    "InputError",
    "Progress",
    "Source",
    "Table",
    "Watching",
    "away_from_here",
    "cache_folder",
    "check_new",
    "check_picture",
    "check_plain",
    "check_room",
    "check_target",
    "claimed",
    "did_you_mean",
    "digest",
    "dotted",
    "is_draft",
    "locked",
    "made_folder",
    "make_folder",
    "new_folder",
    "own_folder",
    "parse_toml",
    "quoted",
    "read_bytes",
    "read_text",
    "read_text_and_zeros",
    "read_text_bytes",
    "read_toml",
    "readable",
    "remove",
    "replacing",
    "require",
    "shown",
    "similar_file",
    "sync_folder",
    "to_toml",
    "write_picture",
    "write_text",
]
