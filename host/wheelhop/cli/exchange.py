"""From what the user typed to effects, and from a result to a file of JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from wheelhop.campaign import CampaignError
from wheelhop.effects import Effect
from wheelhop.files import write_text


def pick(names: Sequence[str], library: Mapping[str, Effect]) -> list[Effect]:
    """The effects of these names, each once; raises CampaignError for a name that is not there."""
    for name in names:
        if name not in library:
            near = get_close_matches(name, library, n=1)
            hint = f'did you mean "{near[0]}"? ' if near else ""
            raise CampaignError(
                f'there is no effect "{name}": {hint}the library has {", ".join(library)}'
            )
    return [library[name] for name in dict.fromkeys(names)]


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write a result for programs to read."""
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
    write_text(path, text + "\n")
