"""Which effects these runs cannot tell apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.look import Candidate
from wheelhop.diagnose.next_run import angle_deg
from wheelhop.diagnose.screen import Screened
from wheelhop.fit import Fit

Array = NDArray[np.float64]

AMBIGUOUS_DEG = 20.0
"""Signatures closer than this differ by less than a third of their size."""


class Angles:
    """Angles between what effects change in the records of the runs fitted.

    Of two effects that were simulated in full it is what each fitted model changes, at the strength
    it was fitted with and with every other number where it then lies: a small friction looks like
    no damper, a damper that has grown to explain the residual may look much like friction. Of
    others it is the first-order signature, after everything the baseline could absorb has been
    taken out of it.
    """

    def __init__(
        self, base: Fit, screened: Sequence[Screened], candidates: Sequence[Candidate] = ()
    ) -> None:
        weight = np.array([(f.scale / f.sigma) ** 2 for f in base.shared]) * base.sigma**2
        stack = np.vstack([run.weighed[:, : run.derivatives.shared] for run in base.runs])
        inner = np.linalg.pinv(stack.T @ stack + np.diag(weight), hermitian=True)
        self._signatures: dict[str, Array] = {}
        for item in screened:
            if any(part.any() for part in item.contribution.values()):
                whole = np.concatenate([item.contribution[run.bench.run.id] for run in base.runs])
                whole = whole - stack @ (inner @ (stack.T @ whole))
                self._signatures[item.variant.effect.id] = whole
        self._changes = {c.id: _change(base, c.rung.fit) for c in candidates if not c.beside}

    def between(self, first: str, second: str) -> float:
        """Angle on all runs, degrees, 0 to 90; 90 where one of them was not screened."""
        both = {first, second}
        for known in (self._changes, self._signatures):
            if both <= known.keys():
                return angle_deg(known[first], known[second])
        return 90.0

    def near(self, effect: str) -> tuple[tuple[str, float], ...]:
        """The effects whose change nearly coincides with this one's, nearest first."""
        others = (self._signatures | self._changes).keys() - {effect}
        angles = [(other, self.between(effect, other)) for other in sorted(others)]
        return tuple(sorted((a for a in angles if a[1] < AMBIGUOUS_DEG), key=lambda a: a[1]))


def _change(base: Fit, fitted: Fit) -> Array:
    """What a fitted model changes in the records of the base's runs, per their spread."""
    residual = {run.bench.run.id: run.residual for run in fitted.runs}
    return np.concatenate(
        [(run.residual - residual[run.bench.run.id]) / run.spread for run in base.runs]
    )
