"""Writing TOML: the values of a table first, then its tables, then its arrays of tables."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from wheelhop.files.write import quoted

Document = Mapping[str, Any]


def to_toml(document: Document) -> str:
    """A document of texts, numbers, lists of them, tables and lists of tables as TOML."""
    return "".join(f"{line}\n" for line in _lines(document))


def _lines(document: Document, path: tuple[str, ...] = ()) -> Iterator[str]:
    tables = {k: v for k, v in document.items() if isinstance(v, Mapping)}
    arrays = {k: v for k, v in document.items() if _is_array_of_tables(v)}
    for key, value in document.items():
        if key not in tables and key not in arrays:
            yield f"{_key(key)} = {_value(value)}"
    for key, table in tables.items():
        inner = (*path, _key(key))
        if any(not isinstance(value, Mapping) for value in table.values()):
            yield from ("", f"[{'.'.join(inner)}]")
        yield from _lines(table, inner)
    for key, array in arrays.items():
        inner = (*path, _key(key))
        for table in array:
            yield from ("", f"[[{'.'.join(inner)}]]")
            yield from _lines(table, inner)


def _is_array_of_tables(value: object) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else quoted(key)


def dotted(name: str) -> str:
    """A name as a part of a dotted key: in quotes, as in TOML, where it holds a dot or a quote, so
    that no key begins with the key of another name and a dot."""
    return quoted(name) if set(name) & set('."') else name


def _value(value: str | float | list[str] | list[float]) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, float):
        return repr(float(value))  # what numpy calls a float prints as np.float64(…)
    return quoted(value) if isinstance(value, str) else repr(value)
