"""What is shipped and what an installation takes along, with versions and licences.

    python tools/sbom.py OUT.cdx.json 'wheelhop[workbench,logger]'

writes a CycloneDX list of everything that the Python it runs with has installed for these
packages, and of what is linked into the firmware (licenses/components.toml), and prints it as
lines of name, version, licence.
"""

import json
import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

SHIPPED = Path(__file__).resolve().parents[1] / "licenses/components.toml"


def needs(dist: Distribution, extras: set[str]) -> Iterator[Requirement]:
    """What a package needs on this machine, with these extras."""
    for requirement in map(Requirement, dist.requires or []):
        marker = requirement.marker
        if marker is None or any(marker.evaluate({"extra": extra}) for extra in {"", *extras}):
            yield requirement


def closure(root: Requirement) -> dict[str, tuple[Distribution, set[str]]]:
    """Every package that one needs, by its name: as it is installed, and the names of its needs."""
    found: dict[str, tuple[Distribution, set[str]]] = {}
    asked, waiting = set(), [root]
    while waiting:
        one = waiting.pop()
        name, extras = canonicalize_name(one.name), frozenset(one.extras)
        if (name, extras) in asked:
            continue
        asked.add((name, extras))
        dist, names = found.setdefault(name, (distribution(name), set()))
        for need in needs(dist, set(extras)):
            names.add(canonicalize_name(need.name))
            waiting.append(need)
    return found


def licence_of(dist: Distribution) -> str:
    """The licence that a package states: an SPDX expression, or else a name."""
    data: Any = dist.metadata
    said = [data[key] for key in ("License-Expression", "License") if data.get(key)]
    names = [
        c.split(" :: ")[-1] for c in data.get_all("Classifier") or [] if c.startswith("License ::")
    ]
    if "License-Expression" not in data and names:
        return ", ".join(names)
    return said[0].strip().splitlines()[0] if said else "not stated"


def component(
    name: str, version: str, licence: str, expression: bool, **more: str
) -> dict[str, Any]:
    """An entry of CycloneDX."""
    stated = {"expression": licence} if expression else {"license": {"name": licence}}
    return {"type": "library", "name": name, "version": version, "licenses": [stated], **more}


def bill(root: Requirement) -> dict[str, Any]:
    """The list as CycloneDX 1.6. Raises PackageNotFoundError for what is not installed."""
    packages = closure(root)
    entries, links = {}, []
    for name, (dist, names) in sorted(packages.items()):
        place = f"pkg:pypi/{name}@{dist.version}"
        stated = licence_of(dist)
        spdx = "License-Expression" in dist.metadata
        entries[name] = component(
            name, dist.version, stated, spdx, **{"bom-ref": place, "purl": place}
        )
        on = sorted(f"pkg:pypi/{other}@{packages[other][0].version}" for other in names)
        links.append({"ref": place, "dependsOn": on})
    main = entries.pop(canonicalize_name(root.name)) | {"type": "application"}
    shipped = tomllib.loads(SHIPPED.read_text(encoding="utf-8"))["component"]
    main["components"] = [
        component(one["name"], one["version"], one["license"], True) | {"type": "firmware"}
        for one in shipped
    ]
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": main},
        "components": list(entries.values()),
        "dependencies": links,
    }


def main(out: str, wanted: str) -> None:
    """Write the list, and print it."""
    try:
        found = bill(Requirement(wanted))
    except PackageNotFoundError as error:
        sys.exit(f"sbom: {error.name} is not installed here: pip install '{wanted}'")
    Path(out).write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    whole = found["metadata"]["component"]
    for one in [whole, *whole["components"], *found["components"]]:
        (stated,) = one["licenses"]
        licence = stated.get("expression") or stated["license"]["name"]
        print(f"{one['name']:28} {one['version']:22} {licence}")


if __name__ == "__main__":
    main(*sys.argv[1:])
