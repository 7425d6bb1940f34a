"""What is played back stands where it was: wheels on the ground that is drawn beneath them."""

import numpy as np
import pytest

from wheelhop.campaign import read_campaign
from wheelhop.track import make_track
from wheelhop.workbench.playback import END_S, scene_of
from wheelhop.workbench.shown import Rung, Shape, Signals

SHAPE = Shape(wheelbase_m=1.4, track_width_m=1.2, radius_m=0.28)
POINTS = ("A1", "A2", "A3", "A4")
RATE_HZ = 100.0
NOTHING = np.zeros((1, 4))


@pytest.fixture(scope="module")
def herringbone(request):
    """A run on waves at an angle: left and right wheels meet them at different times."""
    campaign = read_campaign(request.config.rootpath / "examples/clean")
    return next(run for run in campaign.runs if run.track.kind == "herringbone")


def rigid_wheels(run):
    """A rung whose axles do just what the ground beneath them does."""
    x = 0.3 + run.speed_m_s * np.arange(1000) / RATE_HZ
    track, half = make_track(run.track), SHAPE.track_width_m / 2
    ends = ((0.0, half), (0.0, -half), (SHAPE.wheelbase_m, half), (SHAPE.wheelbase_m, -half))
    heights = np.stack([track.elevation(x - back, y) for back, y in ends], axis=1)
    moved = np.ones_like(heights)
    signals = Signals(RATE_HZ, moved, moved, heights, heights, x)
    names = (run.id,), POINTS, POINTS
    errors = (0.1, 0.1, 0.1, 0.1)
    return Rung((), *errors, False, *names, SHAPE, {}, NOTHING, NOTHING[0], {run.id: signals},
                (), {})  # fmt: skip


@pytest.mark.parametrize("side", ["left", "right"])
def test_wheels_stand_on_the_ground_that_is_drawn(herringbone, side):
    scene = scene_of(herringbone, rigid_wheels(herringbone), side)
    ground = np.array(scene["ground_m"])
    places = scene["ground_from_m"] + scene["ground_step_m"] * np.arange(len(ground))
    position = np.array(scene["position_m"])
    for view in scene["views"]:
        for end, back in (("front", 0.0), ("rear", SHAPE.wheelbase_m)):
            under = np.interp(position - back, places, ground)
            np.testing.assert_allclose(view["axle"][end], under, atol=2e-4)
    assert scene["start_s"] == END_S
    assert len(position) == 1000 - 2 * round(END_S * RATE_HZ)


def test_a_run_that_is_not_modelled_is_not_played(herringbone):
    rung = rigid_wheels(herringbone)
    other = next(iter(rung.signals.values()))
    assert scene_of(herringbone, rung, "left") is not None
    rung.signals.clear()
    rung.signals["another"] = other
    assert scene_of(herringbone, rung, "left") is None
