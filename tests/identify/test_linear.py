"""Linear or not, on recordings of a simulator that shares no code with the model."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import read_campaign
from wheelhop.identify import linearity
from wheelhop.vehicle import read_vehicle

EXAMPLES = Path(__file__).parents[2] / "examples"


def read(name):
    campaign = read_campaign(EXAMPLES / name)
    return campaign, read_vehicle(campaign.vehicle_file)


@pytest.mark.parametrize(
    ("name", "answer"),
    [("clean", "linear"), ("open-driver-seat", "linear"), ("open-dry-friction", "not linear")],
)
def test_a_seat_is_linear_and_friction_is_not(name, answer):
    found = linearity(*read(name))
    assert found.answer == answer
    if answer == "linear":
        assert found.over_floor < 1.5 and found.law is None
        assert (found.coherence > 0.999).all()
    else:
        assert found.over_floor > 3 and found.law == "friction" and found.share > 0.3
        # Friction matters most where little moves.
        levels = sorted((level, error) for _, level, error in found.levels)
        assert levels[0][1] > levels[-1][1]
    assert found.to_json()["answer"] == answer


def test_what_the_axles_do_not_drive_is_not_called_a_law_of_the_struts():
    """A shaker of its own frequency on the body is incoherent with the axles, and may be linear."""
    campaign, vehicle = read("clean")
    rng = np.random.default_rng(1)
    body = np.array([not c.is_axle for c in campaign.channels])

    def shaken(run):
        line = 2.0 * np.sin(2 * np.pi * 22.0 * run.time_s + rng.uniform(0, 6.28))
        return replace(run, record=run.record + line[:, None] * body)

    found = linearity(replace(campaign, runs=tuple(map(shaken, campaign.runs))), vehicle)
    assert found.answer == "cannot tell"
    assert "a line that never decays" in found.sentence


def test_without_what_it_needs_it_cannot_tell_and_says_why():
    campaign, vehicle = read("clean")
    few = replace(campaign, channels=campaign.channels[:-1])
    few = replace(few, runs=tuple(replace(r, record=r.record[:, :-1]) for r in few.runs))
    found = linearity(few, vehicle)
    assert (found.answer, found.to_json()["over_floor"]) == ("cannot tell", None)
    assert "our axle and four body points" in found.sentence
    fitted = linearity(replace(campaign, runs=campaign.fit_runs), vehicle)
    assert "one held out" in fitted.sentence
    short = tuple(
        replace(r, record=r.record[:16], time_s=r.time_s[:16])
        for r in campaign.fit_runs[:2] + campaign.validate_runs[:1]
    )
    assert "too short" in linearity(replace(campaign, runs=short), vehicle).sentence
