"""wheelhop with one effect taken out of its library: python -m benchmarks.blind.without EFFECT …"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from unittest.mock import patch

from wheelhop.cli.main import main
from wheelhop.effects import Effect, load_effects


def ask_without(missing: str, arguments: list[str]) -> int:
    """The program's exit status, called with these arguments."""

    def fewer(user_file: str | Path | None = None) -> Mapping[str, Effect]:
        return {name: e for name, e in load_effects(user_file).items() if name != missing}

    with patch("wheelhop.api.verbs.load_effects", fewer):
        return main(arguments)


if __name__ == "__main__":
    sys.exit(ask_without(sys.argv[1], sys.argv[2:]))
