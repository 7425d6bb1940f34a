"""`wheelhop schema`: the JSON Schema of a file that people write, or of what `--json` writes."""

from __future__ import annotations

from argparse import Namespace

from wheelhop.files import InputError, did_you_mean
from wheelhop.files.schemas import names, schema


def run(arguments: Namespace) -> int:
    """Print one, or the names of all; raises InputError for a name that is not there."""
    if arguments.name is None:
        print("\n".join(names()))
        return 0
    name = arguments.name.removesuffix(".toml")
    if name not in names():
        near = did_you_mean(name, names()) or f"; there are {', '.join(names())}"
        raise InputError(f'there is no schema "{arguments.name}"{near}')
    print(schema(name), end="")
    return 0
