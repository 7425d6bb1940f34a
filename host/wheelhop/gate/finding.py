"""What the gate and the critic say: one sentence with its evidence, and what to do about it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from math import log
from typing import Literal

from wheelhop.campaign.change import Proposal

FALSE_ALARM = 1e-3
"""The chance that a test of the gate speaks up although nothing is wrong. Chosen once, for all."""

When = Literal["before", "after"]
Severity = Literal["certain", "likely", "possible"]


@dataclass(frozen=True)
class Finding:
    """One thing to know before a verdict is believed.

    `when` is "before" a fit (the gate: the campaign is not what its files say) or "after" it (the
    critic: what the fit's own numbers betray). `kind` is the same word for the same mistake;
    `about` says where: a key, a run, channels, a parameter. `text` is one sentence with the
    evidence, `remedy` what to do, `fixes` are changes of the campaign's files that do it.
    """

    when: When
    kind: str
    about: str
    text: str
    remedy: str
    severity: Severity = "likely"
    fixes: tuple[Proposal, ...] = ()


def needed(tried: int) -> float:
    """By how much the logarithm of a likelihood must rise before one of `tried` other descriptions
    is preferred: a ratio of ``tried / FALSE_ALARM`` comes by chance with at most `FALSE_ALARM`
    (Wasserman, Ramdas, Balakrishnan, PNAS 117 (2020) 16880, theorem 1; Bonferroni)."""
    return log(max(tried, 1) / FALSE_ALARM)


def to_json(findings: Iterable[Finding]) -> list[dict[str, str]]:
    """As `diagnose --json` and `compare --json` write them."""
    return [
        {key: value for key, value in asdict(replace(f, fixes=())).items() if key != "fixes"}
        for f in findings
    ]
