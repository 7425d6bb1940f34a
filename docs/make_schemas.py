"""Make the JSON Schemas of the TOML files, and the page that lists every key of them.

    python docs/make_schemas.py

The schemas are traced from the readers (`schema_trace.py`); what a key means is in `keys.toml`.
"""

from __future__ import annotations

import json
import shutil
import tempfile
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import schema_documents as documents
from schema_trace import Json, Node, tracing, unit_words

from wheelhop.calibration import read_constants
from wheelhop.campaign import read_campaign
from wheelhop.campaign.tracks import KINDS
from wheelhop.files import InputError
from wheelhop.report.model_file import read_model
from wheelhop.vehicle import read_vehicle

DOCS = Path(__file__).parent
ROOT = DOCS.parent
SCHEMAS = ROOT / "host/wheelhop/files/schemas"
PAGE = DOCS / "files.md"
DRAFT = "https://json-schema.org/draft/2020-12/schema"
MODEL = """format = 1
campaign = "all keys"
vehicle_name = "car"
written_by = "wheelhop"
effect = []
run = []

[floor]
[channel]
[vehicle.body]
mass_kg = 250.0
"""


def traced() -> dict[str, Json]:
    """The schema of every file, by its name without the ending."""
    asked: Mapping[str, tuple[Callable[[Path], object], Sequence[str]]] = {
        "campaign": (lambda path: read_campaign(path.parent), documents.campaigns()),
        "component": (lambda path: read_campaign(path.parent), documents.components()),
        "vehicle": (read_vehicle, documents.vehicles()),
        "calibration": (read_constants, (documents.CALIBRATION,)),
        "model": (lambda path: read_model(path, {}), (MODEL,)),
    }
    return {name: _schema(name, *each) for name, each in asked.items()}


def _schema(name: str, read: Callable[[Path], object], texts: Sequence[str]) -> Json:
    root = Node(())
    with tempfile.TemporaryDirectory() as folder:
        _prepare(Path(folder))
        file = Path(folder) / f"{'campaign' if name == 'component' else name}.toml"
        for text in texts:
            file.write_text(text, encoding="utf-8")
            # Of a campaign the recordings are empty: its files have been read by then.
            with tracing(root, file), suppress(InputError):
                read(file)
    schema = root.schema()
    _describe(schema, _meanings(name))
    return {"$schema": DRAFT, "title": f"{name}.toml", **schema}


def _prepare(folder: Path) -> None:
    """What the documents name."""
    (folder / "runs").mkdir()
    for kind in KINDS:
        (folder / f"runs/{kind}.csv").touch()
    for name in ("file.csv", "vehicle.toml"):
        (folder / name).touch()
    (folder / "rocker.csv").write_text("wheel_mm,sensor_mm\n-10,7\n0,0\n10,-6\n", encoding="utf-8")
    shutil.copy(ROOT / "examples/bushings/bushing-1-specimen-1.toml", folder / "specimen.toml")
    shutil.copy(ROOT / "examples/frame/baja.toml", folder / "frame.toml")


def _meanings(name: str) -> Mapping[str, str]:
    found = tomllib.loads((DOCS / "keys.toml").read_text(encoding="utf-8"))
    return {**found["all"], **found.get(name, {})}


def _describe(schema: Json, meanings: Mapping[str, str], path: str = "") -> None:
    """Put what a key means, and its unit, into the schema."""
    for name, inner, _ in _keys(schema):
        place = f"{path}{name}"
        told = meaning(meanings, place)
        unit = unit_words(name)
        words = [part for part in (told, f"In {unit}." if unit else "") if part]
        if words:
            inner["description"] = " ".join(words)
        for table in _tables(inner):
            _describe(table, meanings, f"{place}.")


def meaning(meanings: Mapping[str, str], place: str) -> str:
    """What a key means: by its whole name, or by its last part."""
    last = place.rpartition(".")[2]
    if last.endswith("_uncertainty") and place not in meanings and last not in meanings:
        return "One standard deviation of that number."
    return meanings.get(place) or meanings.get(last, "")


def _keys(schema: Json) -> Iterator[tuple[str, Json, bool]]:
    needed = schema.get("required", [])
    for name, inner in schema.get("properties", {}).items():
        yield name, inner, name in needed
    if isinstance(inner := schema.get("additionalProperties"), dict):
        yield "NAME", inner, False


def _tables(schema: Json) -> Iterator[Json]:
    """The tables that may stand under a key."""
    for each in schema.get("anyOf", [schema]):
        if each.get("type") == "object":
            yield each
        elif each.get("type") == "array" and each.get("items", {}).get("type") == "object":
            yield each["items"]


def page(schemas: Mapping[str, Json]) -> str:
    """Every key of every file, as a page."""
    parts = [
        "# Every key of every file\n",
        "Made by `docs/make_schemas.py` from what the readers of the files ask for. `NAME` is a"
        " name of yours; `[]` is each table of a list. Which keys belong together, the pages on"
        " each file say. `wheelhop schema vehicle` prints the same as JSON Schema, with which an"
        " editor such as [Even Better TOML](https://taplo.tamasfe.dev) checks a file while you"
        " write it. What `--json` writes has schemas, too: [programs.md](programs.md).\n",
    ]
    for name, schema in schemas.items():
        parts += [
            f"## {HEADINGS[name]}\n",
            "| key | value | default | meaning |",
            "| --- | --- | --- | --- |",
        ]
        parts += [*_rows(schema, ""), ""]
    return "\n".join(parts)


HEADINGS = {
    "campaign": "campaign.toml of a vehicle",
    "component": "campaign.toml of a component",
    "vehicle": "vehicle.toml",
    "calibration": "calibration.toml",
    "model": "model.toml",
}


def _rows(schema: Json, path: str) -> Iterator[str]:
    for name, inner, needed in _keys(schema):
        default = "must be there" if needed else _shown(inner.get("default", "–"))
        told = inner.get("description", "")
        yield f"| `{path}{name}` | {_value(inner)} | {default} | {told} |"
        for table in _tables(inner):
            listed = inner.get("type") == "array"
            yield from _rows(table, f"{path}{name}{'[]' if listed else ''}.")


def _shown(value: object) -> str:
    return f"`{json.dumps(value, ensure_ascii=False)}`" if value != "–" else "–"


def _value(schema: Json) -> str:
    """The kind of a value and its limits, in words."""
    return " or ".join(_one(each) for each in schema.get("anyOf", [schema]))


def _one(schema: Json) -> str:
    if "enum" in schema:
        return ", ".join(_shown(word) for word in schema["enum"])
    kind = {"object": "table", "array": "list", "string": "text", "boolean": "true or false"}
    name = str(schema.get("type", "any"))
    said = kind.get(name, name)
    if "items" in schema and "minItems" in schema:
        said = f"{schema['minItems']} {schema['items']['type']}s in brackets"
    if schema.get("format") == "date":
        said = "day"
    limits = (("exclusiveMinimum", "above"), ("minimum", "from"), ("exclusiveMaximum", "below"))
    return " ".join([said, *(f"{word} {schema[key]:g}" for key, word in limits if key in schema)])


def files(schemas: Mapping[str, Json]) -> dict[Path, str]:
    """What is made: each file and its text."""
    texts = {
        SCHEMAS / f"{name}.json": json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
        for name, schema in schemas.items()
    }
    return {**texts, PAGE: page(schemas)}


def undescribed(schema: Any, path: str = "") -> list[str]:
    """The keys that nothing is said of."""
    found = []
    for name, inner, _ in _keys(schema):
        found += [] if "description" in inner else [f"{path}{name}"]
        for table in _tables(inner):
            found += undescribed(table, f"{path}{name}.")
    return found


if __name__ == "__main__":
    made = traced()
    for path, text in files(made).items():
        path.write_text(text, encoding="utf-8")
    for name, schema in made.items():
        print(name, *undescribed(schema))
