"""What the readers of TOML files ask of them, as JSON Schema: their calls are the declaration.

`Table` checks a value when a reader asks for it: its kind, its limits, its choices, its default;
`only` says which keys there are. While documents that show every key are read, `tracing` notes all
of that. A reader that takes another key, or another limit, so changes the schema by itself.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wheelhop.files import Table
from wheelhop.files.units import UNITS, split_unit

Json = dict[str, Any]
KINDS = {
    bool: "boolean",
    int: "number",
    float: "number",
    str: "string",
    list: "array",
    dict: "object",
}
ANY_NAME = frozenset((("channels",), ("factors",), ("sensors",)))
"""Tables whose keys are names that users choose."""


@dataclass
class Key:
    """One key: what its calls ask for, and the kinds of value seen."""

    asked: dict[str, list[Json]] = field(default_factory=dict)
    seen: set[str] = field(default_factory=set)
    defaults: set[object] = field(default_factory=set)
    needed: int = 0
    optional: bool = False
    told: bool = False  #: named where what is missing is told all at once
    inner: Node | None = None
    is_list: bool = False

    def schema(self, name: str) -> Json:
        """Any of what was asked for or accepted."""
        found = [{"type": kind, **_loosest(limits)} for kind, limits in self.asked.items()]
        if self.inner is not None:
            table = self.inner.schema()
            found.append({"type": "array", "items": table} if self.is_list else table)
        kinds = {each["type"] for each in found}
        found += [{"type": kind} for kind in sorted(self.seen - kinds - {"date"})]
        if not found and split_unit(name)[1] is not None:
            found = [{"type": "number"}]
        schema: Json = found[0] if len(found) == 1 else {"anyOf": found} if found else {}
        if len(self.defaults) == 1 and (default := next(iter(self.defaults))) != "":
            schema = {**schema, "default": default}
        return schema

    def is_needed(self, visits: int) -> bool:
        """Whether no reader does without it in any of so many tables."""
        always = self.needed >= visits and not self.optional and not self.defaults
        return self.told or always


@dataclass
class Node:
    """One table, however often it stands in the documents."""

    path: tuple[str, ...]
    keys: dict[str, Key] = field(default_factory=dict)
    visits: int = 0
    closed: bool = False

    def key(self, name: str) -> Key:
        """The key of this name; of tables whose keys are names, one for all."""
        return self.keys.setdefault("*" if self.path in ANY_NAME else name, Key())

    def schema(self) -> Json:
        """The table as JSON Schema; open where no reader closes it."""
        if not self.closed and self.path not in ANY_NAME:
            return {"type": "object"}
        if self.path in ANY_NAME:
            return {"type": "object", "additionalProperties": self.keys["*"].schema("")}
        needed = [name for name, key in self.keys.items() if key.is_needed(self.visits)]
        return {
            "type": "object",
            "properties": {name: key.schema(name) for name, key in self.keys.items()},
            "required": sorted(needed),
            "additionalProperties": False,
        }


def _loosest(limits: list[Json]) -> Json:
    """The limits that every call has, the widest of each; all choices of any call."""
    found: Json = {}
    if all("enum" in each for each in limits):
        found["enum"] = list(dict.fromkeys(word for each in limits for word in each["enum"]))
    for name, widest in (("minimum", min), ("exclusiveMinimum", min), ("exclusiveMaximum", max)):
        if all(name in each for each in limits):
            found[name] = widest(each[name] for each in limits)
    for name in ("items", "minItems", "maxItems", "format"):
        if all(name in each for each in limits):
            found[name] = limits[0][name]
    return found


@contextmanager
def tracing(root: Node, file: Path) -> Iterator[None]:
    """Note what readers ask in the block of a file, and of the tables in it; other files that it
    names are read without notice."""
    nodes: dict[int, Node] = {}
    kept: list[Table] = []  # no other table takes the id of one that is gone
    before = {name: getattr(Table, name) for name in (*_ASKS, "only", "needs", "__contains__")}
    before |= {name: getattr(Table, name) for name in ("table", "table_if_any", "tables", "format")}

    def node_of(table: Table) -> Node:
        if id(table) not in nodes:
            is_root = table.file == file and not table.heading
            enter(table, root if is_root else Node(("elsewhere",)))
        return nodes[id(table)]

    def enter(table: Table, node: Node) -> None:
        nodes[id(table)] = node
        kept.append(table)
        for name, value in table.values.items():
            node.key(name).seen.add(KINDS.get(type(value), "date"))

    def asks(name: str, limits: Callable[..., tuple[str, Json, object]]) -> Callable[..., Any]:
        @functools.wraps(before[name])
        def call(self: Table, key: str, *given: Any, **options: Any) -> Any:
            kind, found, default = limits(*given, **options)
            note = node_of(self).key(key)
            note.asked.setdefault(kind, []).append(found)
            if default is None:
                note.needed += 1
            else:
                note.defaults.add(default)
            return before[name](self, key, *given, **options)

        return call

    def only(self: Table, known: Any, *rest: Any, **options: Any) -> None:
        node = node_of(self)
        node.closed, node.visits = True, node.visits + 1
        for name in known:
            node.key(name)
        before["only"](self, known, *rest, **options)

    def needs(self: Table, keys: Any) -> list[str]:
        for name in keys:
            node_of(self).key(name).told = True
        missing: list[str] = before["needs"](self, keys)
        return missing

    def contains(self: Table, key: str) -> bool:
        node_of(self).key(key).optional = True
        return bool(before["__contains__"](self, key))

    def below(self: Table, key: str, *given: Any, **options: Any) -> Table:
        table: Table = before["table"](self, key, *given, **options)
        node, note = node_of(self), node_of(self).key(key)
        note.needed += 1
        note.inner = note.inner or Node((*node.path, key))
        enter(table, note.inner)
        return table

    def maybe(self: Table, key: str) -> Table:
        node_of(self).key(key).optional = True
        table: Table = before["table_if_any"](self, key)
        return table

    def tables(self: Table, key: str, name_key: str) -> list[Table]:
        found: list[Table] = before["tables"](self, key, name_key)
        node, note = node_of(self), node_of(self).key(key)
        note.needed, note.is_list = note.needed + 1, True
        note.inner = note.inner or Node((*node.path, key))
        for table in found:
            enter(table, note.inner)
        return found

    def version(self: Table) -> None:
        note = node_of(self).key("format")
        note.asked["number"], note.needed = [{"enum": [1]}], note.needed + 1
        before["format"](self)

    patched: Mapping[str, Callable[..., Any]] = {
        **{name: asks(name, limits) for name, limits in _ASKS.items()},
        **{"only": only, "needs": needs, "__contains__": contains},
        **{"table": below, "table_if_any": maybe, "tables": tables, "format": version},
    }
    try:
        for name, function in patched.items():
            setattr(Table, name, function)
        yield
    finally:
        for name, function in before.items():
            setattr(Table, name, function)


def _number(
    default: float | None = None,
    *,
    above: float | None = None,
    at_least: float | None = None,
    below: float | None = None,
) -> tuple[str, Json, object]:
    limits = {"exclusiveMinimum": above, "minimum": at_least, "exclusiveMaximum": below}
    return "number", {name: value for name, value in limits.items() if value is not None}, default


def _text(default: str | None = None, choices: Any = ()) -> tuple[str, Json, object]:
    return "string", {"enum": list(choices)} if choices else {}, default


def _pair() -> tuple[str, Json, object]:
    return "array", {"items": {"type": "number"}, "minItems": 2, "maxItems": 2}, None


def _numbers() -> tuple[str, Json, object]:
    return "array", {"items": {"type": "number"}}, None


def _texts() -> tuple[str, Json, object]:
    return "array", {"items": {"type": "string"}}, ""


def _date() -> tuple[str, Json, object]:
    return "string", {"format": "date"}, None


_ASKS: Mapping[str, Callable[..., tuple[str, Json, object]]] = {
    "number": _number,
    "text": _text,
    "pair": _pair,
    "numbers": _numbers,
    "texts": _texts,
    "date": _date,
}


def unit_words(name: str) -> str:
    """The unit that a key ends in, in words; empty for none."""
    unit = split_unit(name)[1]
    return UNITS[unit].words if unit else ""
