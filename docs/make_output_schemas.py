"""Make the JSON Schemas of what `--json` writes.

    python docs/make_output_schemas.py [COMMAND …]

Each is inferred from what the command writes of an example, or of several; tests hold other outputs
against it. A name that only some of them have is optional, and a number may be null where it is not
determined. Read the difference before you keep it: what stands there is a contract.
"""

from __future__ import annotations

import json
import re
import sys
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from wheelhop.cli.main import main

ROOT = Path(__file__).parents[1]
SCHEMAS = ROOT / "host/wheelhop/files/schemas"
DRAFT = "https://json-schema.org/draft/2020-12/schema"
EXAMPLES = ROOT / "examples"
FRICTION, CLEAN = EXAMPLES / "open-dry-friction", EXAMPLES / "clean"
RIG = ROOT / "tests/data/friction-damper"
COMMANDS: Mapping[str, list[list[object]]] = {
    "compare": [["compare", FRICTION, "--add", "dry-friction"], ["compare", RIG]],
    "diagnose": [
        ["diagnose", FRICTION, "--budget", "20", "--max-effects", "2"],
        ["diagnose", CLEAN, "--budget", "20"],
        ["diagnose", RIG, "--budget", "20"],
    ],
    "check": [["check", FRICTION], ["check", RIG]],
    "frame": [["frame", EXAMPLES / "frame/baja.toml"]],
    "modes": [["modes", CLEAN / "vehicle.toml", EXAMPLES / "vehicles/mounts.toml"]],
    "rates": [
        [
            *("rates", EXAMPLES / "rig/front-strut.csv", EXAMPLES / "rig/front-damper.csv"),
            *("--motion-ratio", EXAMPLES / "rig/front-linkage.csv"),
        ]
    ],
    "health": [["health", CLEAN / "runs/washboard-low-slow.csv"]],
    "road": [["road", "iso8608:unevenness_m3=4e-6:waviness=2:seed=1"]],
    "bushing-fit": [["bushing", "fit", EXAMPLES / "bushings/bushing-1-specimen-1.csv"]],
    "plan": [
        [
            *("plan", CLEAN / "vehicle.toml", "--tracks", "washboard/low", "--speeds", "5", "10"),
            *("--runs", "1", "--only", "dry-friction", "--seconds", "4"),
        ]
    ],
    "identify": [["identify", EXAMPLES / "open-driver-seat", "--order", "6"]],
}
MAPS = frozenset(("parameters", "uncertainties", "amplitudes", "rms", "header", "values"))
"""Objects whose names are those of numbers, channels or keys."""
FIXED = re.compile(r"[a-z][A-Za-z0-9_]*")
"""What the names of an object look like that are not the user's."""


def inferred(values: Iterable[Any], name: str = "") -> dict[str, Any]:
    """What all the values are."""
    given = list(values)
    objects = [value for value in given if isinstance(value, dict)]
    lists = [value for value in given if isinstance(value, list)]
    texts = any(isinstance(value, str) for value in given)
    flags = any(isinstance(value, bool) for value in given)
    numbers = any(isinstance(v, int | float) and not isinstance(v, bool) for v in given)
    kinds: list[str] = []
    schema: dict[str, Any] = {}
    if objects:
        kinds.append("object")
        schema |= _of_objects(objects, name)
    if lists:
        kinds.append("array")
        items = [item for each in lists for item in each]
        schema |= {"items": inferred(items)} if items else {}
    kinds += [kind for kind, is_seen in (("string", texts), ("boolean", flags)) if is_seen]
    if numbers:
        kinds.append("number")
    if numbers or any(value is None for value in given):
        kinds.append("null")
    if kinds in ([], ["null"]):
        return {}
    return {"type": kinds[0] if len(kinds) == 1 else kinds, **schema}


def _of_objects(objects: list[dict[str, Any]], name: str) -> dict[str, Any]:
    keys = list(dict.fromkeys(key for each in objects for key in each))
    if name in MAPS or not all(FIXED.fullmatch(key) for key in keys):
        return {"additionalProperties": inferred([v for each in objects for v in each.values()])}
    return {
        "properties": {k: inferred([e[k] for e in objects if k in e], k) for k in keys},
        "required": [key for key in keys if all(key in each for each in objects)],
    }


def written(words: list[object]) -> Any:
    """What a command writes with `--json`."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "out.json"
        status = main([*map(str, words), "--json", str(file)])
        if status not in (0, 1):
            raise SystemExit(f"{words} ended with {status}")
        return json.loads(file.read_text(encoding="utf-8"))


if __name__ == "__main__":
    for command in sys.argv[1:] or COMMANDS:
        found = inferred([written(words) for words in COMMANDS[command]])
        about = {"$schema": DRAFT, "title": f"wheelhop {command.replace('-', ' ')} --json"}
        text = json.dumps({**about, **found}, indent=1, ensure_ascii=False) + "\n"
        (SCHEMAS / f"{command}-output.json").write_text(text, encoding="utf-8")
