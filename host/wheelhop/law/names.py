"""The name of a law by its force: which law of the library comes nearest to it along the motion
recorded.

A strong law that a model lacks moves its other numbers far away, and about such a vehicle no law of
the library shows anything to first order. Its force is known all the same once a free law, or a
formula, has been fitted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from wheelhop.diagnose import Rung
from wheelhop.diagnose.confirm.validate import validate
from wheelhop.diagnose.screen.signatures import Variant, variants, with_variant
from wheelhop.effects import Effect, Switch
from wheelhop.fit import Workshop, effect_parameters, fit
from wheelhop.law.along import force_along
from wheelhop.law.motion import Moves
from wheelhop.law.moved import Moved
from wheelhop.law.places import Where
from wheelhop.law.rival import Rival
from wheelhop.simulate import Model

Array = NDArray[np.float64]

STEPS = 30
"""So many steps are made at most towards the numbers of a named law."""

ENDLESS = 1e6
"""For a force that is none, as beyond the end of an air spring's column."""


def nearest_name(
    workshop: Workshop, law: Rung, where: Where, moves: Moves, library: Sequence[Effect]
) -> Rival | None:
    """The law of the `library` whose force comes nearest to that of the last effect of `law` along
    these motions, its numbers as they come nearest, and from there fitted in full in that one's
    place. None where none has a force there."""
    bare = law.model.without_effect(law.model.effects[-1].id)
    along = _Along.of(workshop, where, moves, law.model)
    trials = [v for effect in library for v in variants(workshop, law.fit, effect)]
    if not along.norm or not trials:
        return None
    left, model = min((_nearest(along, bare, v) for v in trials), key=lambda found: found[0])
    if not left < 1.0:
        return None
    effect = model.effects[-1]
    shared = [free for free in law.fit.shared if free.name in bare.values]
    own = effect_parameters(workshop.parameters_of(effect), model, effect)
    found = fit(workshop, model, [*shared, *own], workshop.of_role("fit"))
    return Rival(effect.id, effect.title, validate(workshop, found))


@dataclass(frozen=True, eq=False)
class _Along:
    """The force (T,) of a law beyond spring and damper at every axle of a place, one after the
    other, along motions with a basis (t, 3) each of what spring and damper do."""

    ends: Sequence[tuple[Where, Moved, Array]]
    step_s: float
    law: Array

    @classmethod
    def of(cls, workshop: Workshop, where: Where, moves: Moves, model: Model) -> _Along:
        """That of the law in a model; of no length where nothing tells how the place moved."""
        ends = []
        for _, end in where.ends():
            if (moved := moves.of(end)) is not None:
                line = np.stack([np.ones_like(moved.rate), moved.extension, moved.rate], axis=1)
                ends.append((end, moved, np.linalg.qr(line)[0]))
        found = cls(ends, 1.0 / workshop.campaign.sample_rate_hz, np.zeros(0))
        return replace(found, law=found.of_model(model))

    @property
    def norm(self) -> float:
        """Root of its sum of squares, N."""
        return float(np.linalg.norm(self.law))

    def of_model(self, model: Model) -> Array:
        """Forces of another model along the same motion."""
        forces = [np.zeros(0)]
        for end, moved, line in self.ends:
            force = force_along(model, end, moved, self.step_s)
            forces.append(force - line @ (line.T @ force))
        return np.concatenate(forces)


def _nearest(along: _Along, bare: Model, variant: Variant) -> tuple[float, Model]:
    """The share of the law's power that the effect's force leaves at best, its shapes begun where
    the variant has them, and the model with it."""
    free = [p for p in variant.parameters if not isinstance(p, Switch)]
    begin = [variant.shapes.get(p.name, p.typical) for p in free]
    start = np.clip(begin, [p.lower for p in free], [p.upper for p in free])

    def model_at(numbers: Array) -> Model:
        values = zip((p.name for p in free), numbers.tolist(), strict=True)
        return with_variant(bare, variant, dict(values))

    def left(numbers: Array) -> Array:
        off = (along.law - along.of_model(model_at(numbers))) / along.norm
        return np.nan_to_num(off, nan=ENDLESS, posinf=ENDLESS, neginf=-ENDLESS)

    if not free or not along.of_model(model_at(start)).any():
        return 1.0, bare
    found = optimize.least_squares(
        left,
        start,
        bounds=([p.lower for p in free], [p.upper for p in free]),
        x_scale=[p.scale for p in free],
        max_nfev=STEPS,
    )
    return 2.0 * float(found.cost), model_at(found.x)
