"""The named tracks against the thesis's text: each number stands here with where it is printed."""

import numpy as np
import pytest

from wheelhop.campaign.proving_ground import proving_ground, table_5_1
from wheelhop.predict import read_drives
from wheelhop.track import Track, make_track

# Table 4.4: amplitude and pitch, mm. Speeds, km/h: tables 4.5 to 4.7, section 4.3.1 for the
# one-sided washboards; all of them again in table 5.1.
SINUSOIDAL = {
    "washboard/low": (15, 400, (7.5, 9.5)),
    "washboard/high": (25, 600, (11, 13)),
    "one-sided-washboard/low": (15, 400, (7,)),
    "one-sided-washboard/high": (25, 600, (13,)),
    "herringbone/low": (10, 500, (9, 14)),
    "herringbone/medium": (15, 600, (21, 25)),
    "herringbone/high": (20, 800, (14, 19)),
    "chassis-twist/low": (150, 2000, (7.5, 15.5)),
    "chassis-twist/medium": (175, 3000, (6.5, 21.5)),
    "chassis-twist/high": (200, 4000, (5.5, 14.5)),
}
OTHERS = {
    "sine-sweep/thesis": (  # table 4.4 and section 4.3.2: 400 to 600 mm in 24 m; 10.5 km/h
        {"amplitude_mm": 15, "pitch_start_mm": 400, "pitch_end_mm": 600, "length_mm": 24000},
        (10.5,),
    ),
    "belgian-pave/thesis": ({"unevenness_m3": 6.7e-4, "waviness": 1.36}, (12,)),  # table 4.8, 4.3.1
    "half-sine-bump/thesis": (  # section 4.3.3
        {"amplitude_mm": 200, "length_mm": 1000}, (7, 15)
    ),
    "half-sine-bump/right": (  # section 4.3.3: "here only the right wheels go over the bump"
        {"amplitude_mm": 200, "length_mm": 1000, "side": "right"}, (5, 12)
    ),
    "step-bump/thesis": ({"height_mm": 80, "width_mm": 200}, (15,)),  # section 4.3.3
}  # fmt: skip
LEFT, RIGHT = 0.59, -0.59
"""Of the vehicle of the examples, m."""


def ground(name: str) -> Track:
    return make_track(read_drives([name], [])[0].track)


def test_there_is_nothing_but_what_the_thesis_drove():
    assert set(proving_ground()) == {*SINUSOIDAL, *OTHERS}
    assert set(table_5_1()) == set(SINUSOIDAL)
    assert sum(len(proving_ground()[name].speeds_kmph) for name in table_5_1()) == 18  # 5.2


@pytest.mark.parametrize("name", SINUSOIDAL)
def test_amplitudes_pitches_and_speeds_are_those_printed(name):
    keys, speeds = proving_ground()[name].keys, proving_ground()[name].speeds_kmph
    assert (keys["amplitude_mm"], keys["pitch_mm"], speeds) == SINUSOIDAL[name]


@pytest.mark.parametrize("name", OTHERS)
def test_other_tracks_are_those_printed(name):
    said, speeds = OTHERS[name]
    assert said.items() <= dict(proving_ground()[name].keys).items()
    assert proving_ground()[name].speeds_kmph == speeds


@pytest.mark.parametrize("name", [name for name in SINUSOIDAL if name.startswith("herringbone")])
def test_herringbones_are_inclined_at_20_degrees(name):
    """Section 4.3.1: a crest under the right wheels is under the left ones w tan 20° later."""
    x, later = np.linspace(0.0, 2.0, 400), (LEFT - RIGHT) * np.tan(np.radians(20.0))
    np.testing.assert_allclose(
        ground(name).elevation(x + later, LEFT), ground(name).elevation(x, RIGHT), atol=1e-12
    )


def test_a_one_sided_washboard_lies_under_the_left_wheels():
    """Section 4.3.1: "the ground excitation acts only on the left wheels"."""
    x = np.linspace(0.0, 2.0, 401)
    for name in ("one-sided-washboard/low", "one-sided-washboard/high"):
        assert np.ptp(ground(name).elevation(x, LEFT)) > 0.0
        assert not ground(name).elevation(x, RIGHT).any()


@pytest.mark.parametrize("name", [name for name in SINUSOIDAL if name.startswith("chassis")])
def test_a_chassis_twist_is_driven_at_the_left_side(name):
    """Section 4.3.1: 4 m wide, "driven at the left side of the track", and on the high severity,
    200 mm of amplitude at the edges, "the input displacement amplitude is 200 mm"."""
    amplitude, pitch, _ = SINUSOIDAL[name]
    crest = pitch / 4 * 1e-3
    left, right = (float(ground(name).elevation(crest, y)) for y in (LEFT, RIGHT))
    assert left == pytest.approx(amplitude * 1e-3)  # on the edge
    assert right == pytest.approx(amplitude * 1e-3 * (2.0 - 1.18) / 2.0)  # left of the middle, too
