"""Every track and its wheel paths as the independent simulator has them."""

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import track_spec
from tests.truth.tracks import elevation, wheel_path
from wheelhop.track import make_track, wheel_envelope

RADIUS = 0.279
WAVES = {"amplitude_mm": 15.0, "pitch_mm": 600.0}
KINDS = {
    "washboard": WAVES,
    "one-sided-washboard": WAVES,
    "herringbone": {**WAVES, "angle_deg": 20.0},
    "chassis-twist": {"amplitude_mm": 150.0, "pitch_mm": 2000.0, "lateral_offset_mm": 100.0},
    "sine-sweep": {
        "amplitude_mm": 10.0,
        "pitch_start_mm": 3000.0,
        "pitch_end_mm": 500.0,
        "length_mm": 30000.0,
    },
    "half-sine-bump": {"amplitude_mm": 50.0, "length_mm": 2900.0, "side": "left"},
    "step-bump": {"height_mm": 40.0, "width_mm": 1300.0},
    "iso8608": {"unevenness_m3": 16e-6, "waviness": 2.0, "seed": 7.0},
    "flat": {},
}


@pytest.fixture
def survey(tmp_path):
    """Two wheel paths, a station every 5 mm."""
    x = np.arange(0.0, 30.0, 0.005)
    left = 0.010 * np.sin(2 * np.pi * x / 0.7) + 0.004 * np.sin(2 * np.pi * x / 0.23)
    right = 0.012 * np.sin(2 * np.pi * x / 1.1 + 0.4)
    file = tmp_path / "paths.csv"
    np.savetxt(
        file, np.column_stack([x, right, left]), delimiter=",", header="x_m,right_m,left_m",
        comments="",
    )  # fmt: skip
    return {"file": str(file)}


@pytest.mark.parametrize("y", [0.59, -0.59], ids=["left", "right"])
@pytest.mark.parametrize("kind", [*KINDS, "profile"])
def test_the_same_ground_and_the_same_wheel_path(kind, y, request):
    keys = request.getfixturevalue("survey") if kind == "profile" else KINDS[kind]
    theirs = truth.Track(kind, keys)
    ours = make_track(track_spec(theirs))
    x = np.linspace(1.0, 29.0, 4001)
    ground = elevation(theirs, x, y)
    np.testing.assert_allclose(ours.elevation(x, y), ground, atol=1e-5)
    path = wheel_path(theirs, y, RADIUS, 1.0, 29.0)(x)
    tolerance = 3e-4 if kind == "step-bump" else 2e-5  # an edge lies between their grid's points
    height = wheel_envelope(ours, y, RADIUS, 1.0, 29.0).height(x)
    np.testing.assert_allclose(height, path, atol=tolerance)
