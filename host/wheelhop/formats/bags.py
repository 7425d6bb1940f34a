"""ROS bags and MCAP, through rosbags and mcap, for reading: a group for each topic."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from wheelhop.files import NUMBERS, check_room
from wheelhop.formats.error import ExchangeError, need
from wheelhop.formats.groups import only_recordings
from wheelhop.formats.mapping import Map
from wheelhop.formats.table import Table, plain_channel

NANOSECONDS, BILLION = 1e-9, 10**9
LONGEST_LIST = 32  # numbers of a field that are channels; longer ones are pictures and scans
ROS = ("sensor_msgs/", "geometry_msgs/", "nav_msgs/")
SI = {
    "linear_acceleration": "m/s²",
    "angular_velocity": "rad/s",
    "twist.linear": "m/s",
    "twist.angular": "rad/s",
    "accel.linear": "m/s²",
}
"""Units of the fields of ROS's own messages (REP 103: SI)."""
STAMP = ("header.stamp.sec", "header.stamp.nanosec")


@dataclass
class _Topic:
    """What was heard on one topic: rows of numbers by their fields, when each was logged, ns, and
    the kind of the messages."""

    kind: str
    rows: list[dict[str, float]] = field(default_factory=list)
    logged_ns: list[int] = field(default_factory=list)


def load(path: Path, mapping: Map | None) -> list[Table]:
    """Read the numbers of every topic, without covariances, pictures and scans."""
    check_room(path, NUMBERS * path.stat().st_size, ExchangeError)
    topics: dict[str, _Topic] = {}
    refused: dict[str, str] = {}
    for name, kind, logged_ns, message in _messages(path, refused):
        topic = topics.setdefault(name, _Topic(kind))
        topic.rows.append(dict(_numbers(message)))
        topic.logged_ns.append(logged_ns)
    tables = [t for name, topic in topics.items() if (t := _table(name, topic, path)) is not None]
    return only_recordings(tables, [f"{name}: {why}" for name, why in refused.items()], path)


def _messages(path: Path, refused: dict[str, str]) -> Iterator[tuple[str, str, int, Any]]:
    """Topic, kind, time of logging in ns and content of each message."""
    if path.suffix.lower() == ".mcap":
        mcap = need("mcap.reader", "ros", path)
        with path.open("rb") as stream:
            reader = mcap.make_reader(stream)
            summary = reader.get_summary()
            known = summary.channels.values() if summary is not None else ()
            encodings = {channel.message_encoding for channel in known}
            if "cdr" not in encodings:
                for schema, channel, message in reader.iter_messages():
                    if channel.message_encoding != "json":
                        refused[channel.topic] = f"is encoded as {channel.message_encoding}"
                        continue
                    kind = schema.name if schema is not None else ""
                    yield channel.topic, kind, message.log_time, json.loads(message.data)
                return
    reader = need("rosbags.highlevel", "ros", path).AnyReader
    stores = need("rosbags.typesys", "ros", path)
    fallback = stores.get_typestore(stores.Stores.LATEST)
    with reader([path], default_typestore=fallback) as bag:
        for connection, logged_ns, data in bag.messages():
            try:
                content = bag.deserialize(data, connection.msgtype)
            except Exception as error:  # a type that nobody defines
                refused[connection.topic] = f"{connection.msgtype}: {str(error)[:60]}"
                continue
            yield connection.topic, connection.msgtype, logged_ns, content


def _numbers(message: Any, path: str = "") -> Iterator[tuple[str, float]]:
    """The numbers in a message, by the names of their fields."""
    for name, value in _parts(message):
        whole = f"{path}.{name}" if path else name
        if "covariance" in name:
            continue
        if isinstance(value, bool | int | float | np.number):
            yield whole, float(value)
        elif isinstance(value, list | np.ndarray):
            if len(value) <= LONGEST_LIST:
                yield from _numbers({f"{name}[{k}]": item for k, item in enumerate(value)}, path)
        elif not isinstance(value, str | bytes) and value is not None:
            yield from _numbers(value, whole)


def _parts(message: Any) -> Iterable[tuple[str, Any]]:
    if isinstance(message, Mapping):
        return message.items()
    fields = getattr(message, "__dataclass_fields__", {})
    return [(name, getattr(message, name)) for name in fields if not name.startswith("__")]


def _table(name: str, topic: _Topic, path: Path) -> Table | None:
    """The numbers of a topic, over the stamps of its messages, or else when they were logged."""
    fields = [key for key in topic.rows[0] if not key.startswith("header.")]
    if not fields:
        return None
    seconds = [int(row.get(STAMP[0], 0)) for row in topic.rows]
    if stamped := min(seconds) > 0:
        parts = [int(row.get(STAMP[1], 0)) for row in topic.rows]
        at_ns = [BILLION * whole + part for whole, part in zip(seconds, parts, strict=True)]
    else:
        at_ns = topic.logged_ns
    time_s = NANOSECONDS * np.array([at - at_ns[0] for at in at_ns], dtype=np.float64)
    return Table(
        file=path,
        kind="bag",
        channels=tuple(plain_channel(key, _unit(key, topic.kind)) for key in fields),
        values=np.array([[row.get(key, np.nan) for key in fields] for row in topic.rows]),
        time_s=time_s,
        start_unix_s=NANOSECONDS * at_ns[0],
        group=name,
        remarks=(f"time is the {'stamp of each message' if stamped else 'time of logging'}",),
    )


def _unit(key: str, kind: str) -> str:
    if not kind.startswith(ROS):
        return ""
    return next((unit for part, unit in SI.items() if f".{part}." in f".{key}."), "")
