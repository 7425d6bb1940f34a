"""Which effects these runs cannot tell apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.diagnose.next_run import angle_deg
from wheelhop.diagnose.screen import Screened
from wheelhop.fit import Fit

Array = NDArray[np.float64]

AMBIGUOUS_DEG = 20.0
"""Signatures closer than this differ by less than a third of their size."""


class Angles:
    """Angles between the contributions effects would make, after everything the baseline could
    absorb has been taken out of them."""

    def __init__(self, base: Fit, screened: Sequence[Screened]) -> None:
        weight = np.array([(f.scale / f.sigma) ** 2 for f in base.shared]) * base.sigma**2
        stack = np.vstack([run.weighed[:, : run.derivatives.shared] for run in base.runs])
        inner = np.linalg.pinv(stack.T @ stack + np.diag(weight), hermitian=True)
        self._parts: dict[str, list[Array]] = {}
        for item in screened:
            if not any(part.any() for part in item.contribution.values()):
                continue
            parts = [item.contribution[run.bench.run.id] for run in base.runs]
            absorbed = inner @ (stack.T @ np.concatenate(parts))
            self._parts[item.variant.effect.id] = [
                part - run.weighed[:, : run.derivatives.shared] @ absorbed
                for part, run in zip(parts, base.runs, strict=True)
            ]

    def between(self, first: str, second: str) -> float:
        """Angle on all runs, degrees, 0 to 90; 90 where one of them was not screened."""
        if first not in self._parts or second not in self._parts:
            return 90.0
        return angle_deg(np.concatenate(self._parts[first]), np.concatenate(self._parts[second]))

    def near(self, effect: str) -> tuple[tuple[str, float], ...]:
        """The effects whose signature nearly coincides with this one's, nearest first."""
        angles = [(other, self.between(effect, other)) for other in self._parts if other != effect]
        return tuple(sorted((a for a in angles if a[1] < AMBIGUOUS_DEG), key=lambda a: a[1]))
