"""Signs of a rig's columns: nothing that is passive gives power away."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import ComponentCampaign, RigRun
from wheelhop.files.words import listed
from wheelhop.gate.finding import Finding
from wheelhop.gate.fixes import turned

Array = NDArray[np.float64]

GIVEN_AWAY = 0.05
"""Share of force times speed, both r.m.s., that a component may seem to give away: of a spring that
moves with 10 Hz as much as follows from sensors 0.8 ms apart."""

SURELY = 0.5
"""Share from which on no delay between two sensors explains it: a third of a half period."""


def sign_findings(campaign: ComponentCampaign) -> Iterator[Finding]:
    """Columns that count the other way: of a passive component force times velocity is positive in
    the mean over a run, what springs and masses store coming back."""
    runs = [run for run in campaign.runs if isinstance(run, RigRun)]
    shares = {run.id: _absorbed(run) for run in runs if np.ptp(run.force) > 0.0}
    active = [run_id for run_id, share in shares.items() if share < -GIVEN_AWAY]
    if active:
        sure = bool(np.median([shares[run_id] for run_id in active]) < -SURELY)
        where = "all runs" if len(active) == len(shares) else listed(active)
        other = "" if sure else ", or the two are recorded with a delay between them"
        yield Finding(
            "before",
            "sign",
            "force_N and displacement_m",
            f"In {where} force times velocity is negative in the mean: the component would give"
            f" power away, which a passive one cannot. One of the columns counts the other way"
            f"{other}.",
            "Both are positive in extension and tension: change the sign of force_N, or of"
            " displacement_m, in these recordings; with neither changed the damping comes out as"
            " nothing.",
            "certain" if sure else "likely",
            fixes=tuple(turned(campaign, [name]) for name in ("force_N", "displacement_m")),
        )
    yield from _of_velocity(campaign, runs)


def _of_velocity(campaign: ComponentCampaign, runs: Sequence[RigRun]) -> Iterator[Finding]:
    """Whether a velocity that was recorded is the rate of the displacement, not its opposite."""
    opposite = [
        run.id
        for run in runs
        if run.velocity is not None and _alike(run.velocity, _rate(run)) < -SURELY
    ]
    if opposite:
        yield Finding(
            "before",
            "sign",
            "velocity_m_s",
            f"In {listed(opposite)} velocity_m_s falls where displacement_m rises: it counts the"
            " other way.",
            "Change the sign of velocity_m_s in these recordings, or leave the column out.",
            "certain",
            fixes=(turned(campaign, ["velocity_m_s"]),),
        )


def _absorbed(run: RigRun) -> float:
    """Power the component absorbs in the mean over a run, over force times speed, both r.m.s."""
    return _alike(run.force, _rate(run))


def _rate(run: RigRun) -> Array:
    return np.asarray(np.gradient(run.displacement, run.time_s))


def _alike(a: Array, b: Array) -> float:
    a, b = a - a.mean(), b - b.mean()
    return float(a @ b) / max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-300)
