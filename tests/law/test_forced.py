"""What a strong law adds to a record follows from the motion that record tells."""

from dataclasses import replace

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, campaign_of, model_of, relative, simulated
from wheelhop.campaign.low_pass import LowPass
from wheelhop.fit import Workshop
from wheelhop.law.along import follow_all, laws_of
from wheelhop.law.formula import Formula
from wheelhop.law.motion import Moves
from wheelhop.law.places import Where
from wheelhop.law.terms import beyond, slipping

TRACK = truth.Track("washboard", {"amplitude_mm": 12.0, "pitch_mm": 1400.0})
RUNS = {"over": truth.Run(TRACK, 3.4, 36.2, np.arange(1024) / 100.0)}


def answered(where, term, force_N, low_pass=None):
    """Relative error of the answer to a term's force along the motion as recorded, and along that
    of the linear model, against what the record of a car with it differs by."""
    linear = model_of(ATV, RUNS)
    formula = Formula(where, [term])
    strong = linear.with_effect(formula, formula.parameters_for(ATV, ()))
    strong = strong.with_values({f"formula.{term.name}_N": force_N})
    none, found = replace(campaign_of(RUNS), low_pass=low_pass), []
    told = simulated(none, strong)
    for records in (told, simulated(none, linear)):
        recorded = replace(campaign_of(RUNS, records), low_pass=low_pass)
        workshop = Workshop(recorded, linear, jobs=1)
        moves = Moves(workshop, linear, strong if records is told else None)
        forced = moves.forced["over"]
        laws = [
            (moves.rows.index(row), kernel, numbers)
            for row, kernel, numbers, _ in laws_of(formula, strong.theta(formula), ATV)
        ]
        force = follow_all(laws, forced.extension, forced.rate, forced.step_s)
        found.append(forced.answers([port for port, *_ in laws], force, [0] * len(laws))[:, 0])
    bench = workshop.benches["over"]
    differs = bench.coefficients(told["over"] - records["over"])
    return [relative(one, differs) for one in found]


@pytest.mark.parametrize(
    ("where", "term", "force_N"),
    [
        (Where("all struts", "strut", (0, 1, 2, 3)), beyond(0.004, 0.02), -160.0),
        (Where("front left strut", "strut", (0,)), slipping(0.002), 120.0),
        (Where("all tyres", "tyre", (0, 1, 2, 3)), slipping(0.002), 150.0),
    ],
    ids=lambda given: getattr(given, "name", None),
)
def test_a_force_along_the_motion_recorded_is_what_a_linear_car_lacks(where, term, force_N):
    recorded, foreseen = answered(where, term, force_N)
    assert recorded < 0.3
    assert recorded < foreseen / 3.0


def test_what_a_force_adds_passes_the_recorder_s_filter_too():
    struts, stop = Where("all struts", "strut", (0, 1, 2, 3)), beyond(0.004, 0.02)
    recorded, foreseen = answered(struts, stop, -160.0, LowPass("butterworth", 2, 15.0))
    assert recorded < 0.25 < foreseen / 2.0
