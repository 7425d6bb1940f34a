"""The process that computes: what is no longer wanted gives way."""

from wheelhop.workbench.order import GiveWay, Order
from wheelhop.workbench.session import Choice
from wheelhop.workbench.shown import Climbed, Converging, Done
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
    Worker(heard.append, lambda: GiveWay(both)).obey(friction)
    assert any(isinstance(m, Climbed) and m.rungs[-1].added == ("dry-friction",) for m in heard)
    assert any(isinstance(m, Converging) for m in heard)  # it is on the way to both
