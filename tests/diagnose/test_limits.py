"""What a clean campaign says it would have shown, it shows; what it says it would not, it does not.

`python -m benchmarks.limits` asks more effects at more strengths.
"""

import json
import math

import pytest

from tests import truth
from tests.diagnose.cases import diagnosed
from wheelhop.diagnose import Limit, to_json
from wheelhop.diagnose.verdict.limits import unseen
from wheelhop.report.words import headline, limit_words

SEED = 101


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    folder = truth.make_campaign(
        tmp_path_factory.mktemp("clean"), seed=SEED, effects={}, short=True, draft=True
    )
    return diagnosed(folder)


def test_none_says_what_it_would_have_shown(clean):
    named = {limit.effect: limit for limit in clean.limits}
    assert {"dry-friction", "driver-seat", "tyre-lift-off"} <= set(named)
    # An effect that leaves every run numbers of its own and no other has no limit of its own.
    assert "speed-fluctuation" not in named
    assert 0.0 < named["dry-friction"].amplitudes["front_N"] < 5.0  # the vehicle weighs 2.3 kN
    assert limit_words(named["dry-friction"]).startswith("front ")
    document = to_json(clean)
    assert json.loads(json.dumps(document))["limits"] == document["limits"]


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "shown"), [(0.4, False), (2.5, True)])
def test_the_limit_holds(clean, tmp_path, factor, shown):
    """An anti-roll bar well below and well above its limit, on the same drives."""
    least = {limit.effect: limit.amplitudes for limit in clean.limits}["anti-roll-bar"]
    hidden = {f"stiffness_{end}_N_m": factor * least[f"{end}_N_m"] for end in ("front", "rear")}
    effects = {"anti-roll-bar": hidden}
    folder = truth.make_campaign(tmp_path, seed=SEED, effects=effects, short=True, draft=True)
    found = diagnosed(folder)
    assert found.verdict == (("anti-roll-bar",) if shown else ("none",))
    assert ("anti-roll-bar" in {limit.effect for limit in found.limits}) is not shown


def test_what_the_runs_cannot_show_is_not_said_to_be_absent(tmp_path):
    """Washboards lift both sides alike: no bar works on them, whatever its rate."""
    folder = truth.make_campaign(tmp_path, seed=SEED, effects={}, short=True, draft=True)
    head, *runs = (folder / "campaign.toml").read_text().split("\n[[run]]")
    kept = [run for run in runs if 'track.kind = "washboard"' in run]
    (folder / "campaign.toml").write_text("\n[[run]]".join([head, *kept]))
    found = diagnosed(folder)
    bar = next(limit for limit in found.limits if limit.effect == "anti-roll-bar")
    assert found.verdict == ("none",) and not bar.shown
    assert any("hardly have shown anti-roll-bar" in line for line in found.explanation)
    assert found.confidence < 1.0 - 1.0 / 30  # one machine in as many as there are effects has it
    assert "that these runs could show" in headline(found)


def test_unseen_is_a_chance():
    def limit(chance):
        return Limit("bump-stop", "", {}, True, chance)

    assert unseen([], 30) == 0.0 == unseen([limit(0.0)] * 30, 30)
    assert unseen([limit(1.0)], 30) == pytest.approx(1 / 30)
    # None of the library can be seen: as sure as that a machine with one effect on average has one.
    assert unseen([limit(1.0)] * 10_000, 10_000) == pytest.approx(1.0 - math.exp(-1.0), rel=1e-3)
