"""The process that computes: what is no longer wanted gives way."""

import re
import signal

import pytest

from tests.compare.test_settings import driven
from tests.component import rig
from wheelhop.compare.settings import compare_settings
from wheelhop.workbench import show
from wheelhop.workbench.order import Enough, GiveWay, Order, how_it_ended
from wheelhop.workbench.session import Choice
from wheelhop.workbench.shown import (
    CanShow,
    Climbed,
    Concluded,
    Converging,
    Done,
    Law,
    Refused,
    Said,
)
from wheelhop.workbench.worker import Worker


def test_a_model_no_longer_wanted_gives_way_and_what_is_fitted_stays(small):
    """Friction and a seat were asked for, the seat is taken out while it is being fitted."""
    both = Order(small, Choice(added=("dry-friction", "driver-seat")))
    friction = Order(small, Choice(added=("dry-friction",)))
    heard = []

    def newer():
        fitted = {rung.added for m in heard if isinstance(m, Climbed) for rung in m.rungs}
        return GiveWay(friction) if ("dry-friction",) in fitted else None

    worker = Worker(heard.append, newer)
    worker.obey(both)
    climbed = [m.rungs[-1].added for m in heard if isinstance(m, Climbed)]
    assert climbed[-1] == ("dry-friction",) and heard[-1] == Done("")

    heard.clear()
    worker.obey(friction)
    assert [type(m) for m in heard] == [Climbed, Done]  # nothing is fitted anew

    heard.clear()
    worker.obey(Order(small, Choice(), wish="foresee"))
    (can_show,) = [m for m in heard if isinstance(m, CanShow)]
    assert re.match(r"front .* N and rear .* N", can_show.effects["dry-friction"])

    heard.clear()
    Worker(heard.append, lambda: GiveWay(both)).obey(friction)
    assert any(isinstance(m, Climbed) and m.rungs[-1].added == ("dry-friction",) for m in heard)
    assert any(isinstance(m, Converging) for m in heard)  # it is on the way to both


def test_settings_are_compared_without_a_model(small):
    """Of runs that name none that is said at once, and nothing is fitted for it."""
    heard = []
    Worker(heard.append).obey(Order(small, Choice(), wish="settings"))
    assert "no setting is stated" in heard[-1].line
    assert {type(m) for m in heard} <= {Said, Refused}
    dampers = (("soft", 1.0), ("hard", 3.0))
    found = show.settings(compare_settings(driven(1, dampers)))
    assert found.html.startswith("<h2>hard differs from soft</h2>")
    assert found.html.count("<figure") == 1


def test_where_enough_is_known_a_diagnosis_ends_with_the_verdict_so_far(friction):
    """It is enough once the first effect is simulated; said afterwards, it means nothing."""
    heard = []

    def newer():
        simulated = [m for m in heard if isinstance(m, Said) and "simulating" in m.text]
        return Enough() if len(simulated) > 1 else None

    worker = Worker(heard.append, newer)
    worker.obey(Order(friction, Choice(), wish="diagnose"))
    (concluded,) = [m for m in heard if isinstance(m, Concluded)]
    assert "interrupted" in repr(concluded.verdict)
    assert heard[-1] == Done("")
    worker.obey(Order(friction, Choice(added=("driver-seat",))))
    assert heard[-1] == Done("")


def test_a_rig_whose_names_end_above_the_floor_shows_the_law_beyond_them(tmp_path):
    """As the command does, in the same diagnosis."""
    strange = rig.Component(hidden="bypass-damper", numbers={"share": 1.0, "travel_m": 0.02})
    folder = rig.make_campaign(
        tmp_path / "c", "displacement", strange, seed=2, noise=0.01, only="random"
    )
    heard = []
    Worker(heard.append).obey(Order(folder, Choice(), wish="diagnose"))
    (law,) = [m for m in heard if isinstance(m, Law)]
    assert law.lines[0].startswith("In place of names") and law.figure
    assert isinstance(heard[-1], Done)


BROKEN = """
from wheelhop.effects import Amplitude, Effect


class Boom(Effect):
    id, place, title = "boom", "sensor", "one that fails"
    equation = source = "-"

    def parameters_for(self, vehicle, channels):
        return (Amplitude("size", "1", "nothing", 1.0),)

    def sense(self, theta, acceleration, channels, rate_hz):
        raise RuntimeError("boom: no such <b>thing</b>\\nat all")
"""


def test_a_fault_is_told_as_it_happened_and_the_next_order_is_obeyed(small, tmp_path):
    """Not that memory may have run out; and the process lives on."""
    file = tmp_path / "mine.py"
    file.write_text(BROKEN)
    heard = []
    worker = Worker(heard.append)
    worker.obey(Order(small, Choice(added=("boom",)), effects_file=file))
    assert isinstance(heard[-1], Refused)
    assert "RuntimeError: boom: no such <b>thing</b> at all" in heard[-1].line
    assert "line 13 of mine.py" in heard[-1].line and "memory" not in heard[-1].line
    worker.obey(Order(small, Choice()))
    assert heard[-1] == Done("")


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="there are no signals here")
def test_only_a_process_that_the_system_killed_is_said_to_have_lacked_memory():
    assert "memory" in how_it_ended(-signal.SIGKILL)
    for status in (-signal.SIGSEGV, -signal.SIGTERM, 1, 0, None):
        assert "memory" not in how_it_ended(status)
    assert "Segmentation fault" in how_it_ended(-signal.SIGSEGV)
