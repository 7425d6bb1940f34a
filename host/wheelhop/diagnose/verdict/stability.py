"""What is said of models that ran away while effects were sought beside them."""

from __future__ import annotations

from collections.abc import Iterable

from wheelhop.files.words import listed
from wheelhop.gate import Finding


def unstable(run_away: Iterable[tuple[str, tuple[str, ...]]]) -> list[Finding]:
    """Runs in which models were not stable where an effect looked at them, by their effects."""
    runs: dict[str, list[str]] = {}
    for run_id, effects in sorted(run_away):
        runs.setdefault(" + ".join(("baseline", *effects)), []).append(run_id)
    return [
        Finding(
            "after",
            "runs-away",
            ", ".join(ids),
            f"The model {name} runs away in {listed(ids)}: what would begin at its motion there"
            " began at its usual values instead.",
            "Look at the numbers of these effects before you trust what was tried beside them.",
            "possible",
        )
        for name, ids in runs.items()
    ]
