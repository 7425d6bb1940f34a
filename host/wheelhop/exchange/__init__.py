"""Recordings from and to the formats of others; optional libraries load when they are needed."""

from wheelhop.exchange.draft import draft_mapping
from wheelhop.exchange.error import ExchangeError
from wheelhop.exchange.formats import FORMATS, losses, read, write
from wheelhop.exchange.mapping import Map, Pick, read_mapping

__all__ = [
    "FORMATS",
    "ExchangeError",
    "Map",
    "Pick",
    "draft_mapping",
    "losses",
    "read",
    "read_mapping",
    "write",
]
