"""JSON Schemas of the files that people write, and of what `--json` writes; made by
`docs/make_schemas.py` and `docs/make_output_schemas.py`."""

from importlib.resources import files


def names() -> list[str]:
    """Of all schemas: "vehicle" of vehicle.toml, "compare-output" of `compare --json`."""
    found = (item.name for item in files(__name__).iterdir())
    return sorted(name.removesuffix(".json") for name in found if name.endswith(".json"))


def schema(name: str) -> str:
    """The text of one of `names`."""
    return (files(__name__) / f"{name}.json").read_text(encoding="utf-8")
