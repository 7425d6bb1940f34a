"""The three classes of an effect's numbers, and scripts that still write `Parameter(…)`."""

import pytest

from wheelhop.campaign import CampaignError
from wheelhop.effects import Amplitude, Parameter, Shape, Switch


def test_where_each_class_begins_and_shows():
    friction = Amplitude("slip_N", "N", "slip force", 40.0, absent=3.0)
    knee = Shape("knee_m_s", "m/s", "knee", 0.2, starts=(0.1, 0.4))
    cable = Switch("wrong", "1", "1: inverted")
    assert [(p.start, p.typical) for p in (friction, knee, cable)] == [
        *((3.0, 43.0), (0.1, 0.1), (0.0, 1.0))
    ]
    assert (cable.lower, cable.upper) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("more", "new"),
    [
        ({"lower": 0.0}, Amplitude("x", "1", "number", 2.0, lower=0.0)),
        ({"starts": (1.0,)}, Shape("x", "1", "number", 2.0, starts=(1.0,))),
        ({"switch": True, "lower": 0.0, "upper": 1.0}, Switch("x", "1", "number", 2.0)),
    ],
)
def test_the_old_way_to_write_a_parameter_gives_the_class_and_warns(more, new):
    with pytest.warns(DeprecationWarning, match=rf"x: write {type(new).__name__}\(…\)") as told:
        old = Parameter("x", "1", "number", 2.0, **more)
    assert type(old) is type(new) and old == new
    assert told[0].filename == __file__


def test_a_shape_that_begins_nowhere_is_refused():
    with pytest.raises(CampaignError, match=r"knee: .* give it starts"):
        Shape("knee", "1", "knee", 1.0, starts=())
