"""Recordings from and to the formats of others; optional libraries load when they are needed."""

from wheelhop.formats.draft import draft_mapping, understand
from wheelhop.formats.error import ExchangeError
from wheelhop.formats.mapping import Map, Pick, parse_mapping, read_mapping
from wheelhop.formats.registry import FORMATS, is_foreign, losses, read, write
from wheelhop.formats.understood import Understood

__all__ = [
    "FORMATS",
    "ExchangeError",
    "Map",
    "Pick",
    "Understood",
    "draft_mapping",
    "is_foreign",
    "losses",
    "parse_mapping",
    "read",
    "read_mapping",
    "understand",
    "write",
]
