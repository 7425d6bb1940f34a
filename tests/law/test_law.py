"""The law a model is missing: in the records of rigs that share no code, with laws of nobody's."""

import re
import runpy
from collections.abc import Callable
from dataclasses import dataclass, replace
from json import dumps

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from tests.component import rig
from wheelhop.campaign import read_campaign
from wheelhop.cli.main import main
from wheelhop.effects import load_effects
from wheelhop.law import find_law
from wheelhop.law.along import follow_all
from wheelhop.law.formula import Formula, source_of
from wheelhop.law.free import free_force
from wheelhop.law.look import kind_of, look, shape_of
from wheelhop.law.motion import Moves
from wheelhop.law.names import nearest_name
from wheelhop.law.places import Where
from wheelhop.law.shape import forces
from wheelhop.law.terms import beyond, candidates, creeping, slip, slipping, valved
from wheelhop.report.law import amplitudes, law_figure, law_lines, law_to_json, shapes
from wheelhop.vehicle import read_nominal


@dataclass(frozen=True)
class Special(rig.Component):
    """A component with any law f(x, v) without memory."""

    special: Callable[[float, float], float] | None = None

    def law(self):
        return self.special


def cubic_with_one_percent(x, v):
    """At 20 mm 400 N of line, 800 N of cube, and a hundredth of that uneven."""
    return 20000.0 * x + 1e8 * x**3 + 2e4 * x**2 + 1500.0 * v


def fading_damper(x, v):
    """Its oil foams: force that falls again beyond a speed."""
    return 20000.0 * x + 1500.0 * v / (1.0 + (v / 0.3) ** 2)


def magic_bump_rubber(x, v):
    """A rubber of a curve with a knee, in compression beyond 8 mm."""
    deep = max(-x - 0.008, 0.0)
    return 20000.0 * x + 1500.0 * v - 900.0 * np.sin(1.3 * np.arctan(150.0 * deep))


def orifice_and_cubic(x, v):
    """Two things at once, each with a name of its own."""
    return 20000.0 * x + 1500.0 * v + 3000.0 * v * abs(v) + 3e7 * x**3


def block_in_compression(x, v):
    """A stiff block that is met 8.3 mm below, between the gaps of any grid."""
    return 20000.0 * x + 1500.0 * v + 60000.0 * min(x + 0.0083, 0.0)


def campaign_of(folder, special=None, hidden="", numbers=None, noise=0.005, seconds=5.0):
    component = (
        Special(special=special) if special else rig.Component(hidden=hidden, numbers=numbers or {})
    )
    return rig.make_campaign(
        folder, "displacement", component, seed=3, noise=noise, seconds=seconds
    )


def found_in(folder):
    campaign = read_campaign(folder)
    library = list(load_effects().values())
    return find_law(campaign, read_nominal(campaign), [], library, lambda text: None)


def test_the_spline_is_not_a_knot_and_straight_beyond_its_ends():
    knots, values = np.array([-2.0, -0.5, 0.0, 1.0]), np.array([3.0, -1.0, 0.0, 2.0])
    exact = CubicSpline(knots, values)
    p = np.concatenate([[4, 0], knots, values, exact(knots, 2), np.zeros(9)])
    q = np.concatenate([[0, 4], knots, values, exact(knots, 2), np.zeros(9)])
    for at in (*np.linspace(-2.0, 1.0, 31), -2.0 - 1e-9, 1.0 + 1e-9):
        assert free_force(at, 9.0, 0, 0, 0, p)[0] == pytest.approx(exact(at), abs=1e-7)
        assert free_force(9.0, at, 0, 0, 0, q)[0] == pytest.approx(exact(at), abs=1e-7)
    assert free_force(3.0, 0, 0, 0, 0, p)[0] == pytest.approx(2.0 + 2.0 * exact(1.0, 1))
    assert free_force(-4.0, 0, 0, 0, 0, p)[0] == pytest.approx(3.0 - 2.0 * exact(-2.0, 1))


def test_a_slider_turns_a_closed_loop_of_known_area():
    """4 F (X - d) a cycle of amplitude X: a spring that slips after d (W. D. Iwan 1966)."""
    x = 0.02 * np.sin(np.linspace(0.0, 4 * np.pi, 40001))
    p, stretch, force = np.array([300.0, 0.005]), 0.0, np.zeros(len(x))
    for t, dx in enumerate(np.diff(x, prepend=0.0)):
        force[t], stretch = slip(x[t], 0.0, dx, 0.0, stretch, p)
    area = np.trapezoid(force[20000:], x[20000:])
    assert area == pytest.approx(4 * 300.0 * (0.02 - 0.005), rel=1e-3)


def test_stretches_know_nothing_of_what_came_before_them():
    rng = np.random.default_rng(8)
    x = np.cumsum(rng.normal(0.0, 0.01, (60, 1)), axis=0)
    laws, v = [(0, slip, (300.0, 0.005))], np.zeros_like(x)
    each = [follow_all(laws, x[a:b], v[a:b], 0.01) for a, b in ((0, 25), (25, 26), (26, 60))]
    together = follow_all(laws, x, v, 0.01, stretches=(25, 1, 34))
    assert np.array_equal(together, np.concatenate(each))
    assert not np.allclose(together, follow_all(laws, x, v, 0.01))


def test_a_valve_opens_at_one_speed_and_shuts_at_another():
    """Either way: nothing before it opens, then the slope from where it shuts, until it does."""
    term, z, forces = valved(0.3, 0.5, 1.0), 0.0, []
    for v in (0.2, 0.29, 0.4, 0.2, 0.16, 0.14, 0.2, -0.31, -0.2):
        force, z = term.kernel(0.0, v, 0.0, 1e-3, z, np.array([100.0, *term.shape]))
        forces.append(force)
    expected = [0.0, 0.0, 25.0, 5.0, 1.0, 0.0, 0.0, -16.0, -5.0]
    assert forces == pytest.approx(expected, abs=1e-9)


def test_a_law_is_told_by_what_it_follows():
    rng = np.random.default_rng(5)
    x, v = rng.normal(0.0, 0.01, 20000), rng.normal(0.0, 0.2, 20000)
    history = rng.normal(0.0, 300.0, 20000)
    assert kind_of(1e8 * x**3 + 0.1 * history, x, v)[0] == "spring"
    assert kind_of(2000.0 * v * np.abs(v), x, v)[0] == "damper"
    assert kind_of(1e5 * x * v, x, v)[0] == "both"
    assert kind_of(history, x, v) == ("memory", pytest.approx(0.0, abs=0.03))


def test_a_law_is_told_by_its_shape():
    v = np.random.default_rng(5).normal(0.0, 0.2, 20000)
    assert "faster than the speed, alike" in shape_of(v**3, v, "damper")
    assert "slower than the speed, alike" in shape_of(-(v**3), v, "damper")
    assert shape_of(v**2 * (v > 0), v, "damper").endswith("most of it in rebound.")
    assert shape_of(v**2 * (v < 0), v, "damper").endswith("most of it in compression.")


def test_nothing_is_found_where_nothing_is_missing(tmp_path):
    found = found_in(campaign_of(tmp_path / "c"))
    assert found.free is None and found.preferred is None
    assert law_lines(found) == ["Nothing to find: the model explains these runs down to the noise."]


def _with_force(folder, added):
    """A campaign of a linear component, with a force (T,) added that is no law of its motion."""
    campaign_of(folder)
    for file in (folder / "runs").iterdir():
        time_s, x, force = np.loadtxt(file, delimiter=",", skiprows=1).T
        table = np.stack([time_s, x, force + added(time_s, x)], axis=1)
        header = "time_s,displacement_m,force_N"
        np.savetxt(file, table, fmt="%.9g", delimiter=",", header=header, comments="")
    return folder


def test_what_no_place_explains_is_said_to_be_left(tmp_path):
    """Damping that comes and goes while the record runs: it follows no motion, nor how long it has
    been going on."""
    folder = _with_force(
        tmp_path / "c",
        lambda t, x: 500.0 * np.cos(14 * np.pi * t / t[-1]) * np.gradient(x, t),
    )
    found = found_in(folder)
    assert found.base.error > 5.0 * 0.005
    first, *then = law_lines(found)
    assert found.free is None and "more than noise is left" in first
    assert any("record it as an input" in line for line in then)


def test_a_damper_that_fades_is_told_as_one_that_changes_with_time(tmp_path):
    """Its damping falls by a third from the beginning of each run to its end."""
    folder = _with_force(tmp_path / "c", lambda t, x: -500.0 * t / t[-1] * np.gradient(x, t))
    found = found_in(folder)
    assert found.formula.words.startswith("damping that changes, per 10 s")
    assert found.formula.rung.error < 1.3 * 0.005
    (fall, _), *_ = amplitudes(found.formula).values()
    end_s = found.workshop.of_role("fit")[0].run.time_s[-1]
    at_end = -500.0 * np.abs(found.moved.rate).max() * 10.0 / end_s
    assert fall == pytest.approx(at_end, rel=0.05)


def test_one_percent_of_asymmetry_comes_out_as_asymmetry_and_not_as_a_stop(tmp_path):
    found = found_in(campaign_of(tmp_path / "c", cubic_with_one_percent, noise=0.002))
    x, v = found.moved.extension, found.moved.rate
    law = forces(found, found.free)
    basis = np.stack([x, x**2, x**3, v, v * abs(v), np.ones_like(x)], axis=1)
    square = np.linalg.lstsq(basis, law, rcond=None)[0][1]
    assert square == pytest.approx(2e4, rel=0.3)
    assert "cubic spring" in found.formula.words and "quadratic spring" in found.formula.words
    assert "stop" not in found.formula.words
    surface, doubt, *_ = law_figure(found).subfigs[1].axes
    grey = [np.ma.getmaskarray(panel.collections[0].get_array()) for panel in (surface, doubt)]
    middle = tuple(n // 2 for n in grey[0].shape)
    for cells in grey:  # nothing went fast at the ends of the travel; all went through rest
        assert cells[0, 0] and cells[-1, -1] and not cells[middle]
    said = " ".join(look(found))
    assert "follows the extension" in said and "stiffens towards the ends" in said
    assert "one comes nearest, cubic spring" in said and "slow strokes" in said


@pytest.mark.parametrize("seed", [3, pytest.param(5, marks=pytest.mark.slow)])
def test_under_an_imposed_force_one_percent_of_asymmetry_has_its_sign_and_size(seed, tmp_path):
    """As in the Silverbox: a light mass on a spring whose cube is twice its line, shaken; the law
    without it is off by as much as the motion."""
    mass = Special(mass_kg=5.0, special=lambda x, v: cubic_with_one_percent(x, v) - 1380.0 * v)
    folder = rig.make_campaign(tmp_path / "c", "force", mass, seed=seed, noise=0.002, only="random")
    found = found_in(folder)
    assert found.base.error > 0.5
    x, v = found.moved.extension, found.moved.rate
    basis = np.stack([x, x**2, x**3, v, v * abs(v), np.ones_like(x)], axis=1)
    for rival in (found.free, found.formula):
        spring, square, cube, damper, *_ = np.linalg.lstsq(basis, forces(found, rival))[0]
        assert (spring, damper) == pytest.approx((20000.0, 120.0), rel=0.01)
        assert square == pytest.approx(2e4, rel=0.1)
        assert cube == pytest.approx(1e8, rel=0.01)
        assert rival.rung.error < 1.3 * 0.002
    assert "cubic spring" in found.formula.words and "quadratic spring" in found.formula.words
    assert "stop" not in found.formula.words


@pytest.mark.parametrize(
    "law",
    [pytest.param(fading_damper, marks=pytest.mark.slow), magic_bump_rubber],
    ids=lambda law: law.__name__,
)
def test_a_law_in_nobodys_library_is_within_a_tenth_over_the_range_driven(law, tmp_path):
    found = found_in(campaign_of(tmp_path / "c", law))
    x, v = found.moved.extension, found.moved.rate
    truth = np.array([law(*pair) for pair in zip(x, v, strict=True)])
    off = forces(found, found.free) - truth
    assert np.std(off) < 0.1 * np.std(truth - 20000.0 * x)
    assert found.free.rung.error <= 1.3 * 0.005


def test_terms_read_as_an_engineer_writes_them():
    """No exponents in millimetres, and no minus of a minus."""
    assert creeping(1.1).words == "friction that creeps below 1100 mm/s"
    assert slipping(0.0013123).words == "friction that gives way elastically by 1.31 mm"
    assert r"\langle x + 8.3\,mm\rangle" in beyond(-0.0083, 0.02).equation
    assert r"\langle x - 12\,mm\rangle" in beyond(0.012, 0.02).equation
    assert r"\langle x\rangle" in beyond(0.0, 0.02).equation


@pytest.fixture(scope="module")
def friction(tmp_path_factory):
    """What is found where friction in a joint is missing."""
    numbers = {"coulomb_N": 250.0, "joint_N_m": 4e5}
    folder = tmp_path_factory.mktemp("friction") / "c"
    return found_in(campaign_of(folder, hidden="dry-friction", numbers=numbers))


def test_a_law_with_a_name_is_called_by_it(friction):
    assert friction.preferred.name == "dry-friction"
    assert "The nearest name is dry-friction" in " ".join(look(friction))


def test_a_name_is_known_by_the_force_of_a_law_that_was_found(friction):
    """Told from the force of a formula alone."""
    found, library = friction, [e for e in load_effects().values() if e.on_rig]
    workshop, law, where = found.workshop, found.formula.rung, found.where
    nearest = nearest_name(workshop, law, where, Moves(workshop, law.model), library)
    assert nearest.name == "dry-friction"
    values = nearest.rung.model.values
    assert values["dry-friction.strut_N"] == pytest.approx(250.0, rel=0.02)
    assert values["dry-friction.presliding_N_m"] == pytest.approx(4e5, rel=0.1)
    assert nearest.rung.error <= 1.05 * min(r.rung.error for r in found.named)
    assert nearest_name(workshop, law, where, Moves(workshop, law.model), []) is None


def test_a_law_that_runs_away_is_told_and_held_against_no_name(friction):
    """As a free law does of which one held-out run goes further than any that was fitted."""
    found = replace(friction, named=friction.named[-1:])
    (told,) = [line for line in look(found) if "nearest name" in line]
    assert "100 %" not in told
    judging = found.free.rung.validation
    infinite = [replace(run, residual=run.residual * np.inf) for run in judging.runs]
    astray = replace(judging, runs=tuple(infinite))
    away = replace(found.free, rung=replace(found.free.rung, validation=astray))
    assert away.rung.error == np.inf
    found = replace(found, free=away)
    assert told in look(found)
    assert f"{'free':22} {100 * away.rung.error_fit:7.2f}% runs away" in law_lines(found)
    assert dumps(law_to_json(found), allow_nan=False)
    drawn = [panel.get_title(loc="left") for panel in law_figure(found).axes]
    assert "free: held out, it runs away" in drawn


def test_a_gap_that_was_fitted_is_told_with_its_interval(tmp_path):
    found = found_in(campaign_of(tmp_path, block_in_compression))
    (words, (gap, deviation, unit)), *others = shapes(found.formula).items()
    assert not others and "gap" in words and unit == "m"
    assert abs(gap + 0.0083) < 3 * deviation < 0.0003
    assert f"  {words}: {1e3 * gap:.4g} ± {1e3 * deviation:.2g} mm" in law_lines(found)


def test_the_formula_that_is_kept_is_an_effect_that_diagnose_finds(tmp_path, capsys):
    folder = campaign_of(tmp_path / "c", orifice_and_cubic, seconds=3.0)
    kept, picture, page = (tmp_path / name for name in ("my_law.py", "law.png", "law.html"))
    asked = ["--save", str(kept), "--figure", str(picture), "--report", str(page)]
    assert main(["law", str(folder), *asked]) == 0
    said = capsys.readouterr().out
    assert "damping that grows with speed squared" in said and "cubic spring" in said
    assert picture.read_bytes().startswith(b"\x89PNG")
    html = page.read_text(encoding="utf-8")
    assert "A force is missing at the component." in html
    assert html.count("<svg") == 3  # the picture, and the equation of each term
    for words in ("damping that grows with speed squared", "cubic spring"):
        row = rf"<td>{words}</td><td>.*?</td><td class=\"r\">[^<]* ± [^<]* N"
        assert re.search(row, html, re.DOTALL)
    result = tmp_path / "result.json"
    arguments = ["diagnose", str(folder), "--effects", str(kept), "--json", str(result)]
    assert main([*arguments, "--jobs", "1"]) == 0
    assert '"verdict": [\n    "found-law"\n  ]' in result.read_text()


def test_every_term_survives_the_file(tmp_path):
    """Each kept kernel computes what the term it came from computes."""
    rng = np.random.default_rng(1)
    terms = candidates(rng.uniform(-0.02, 0.03, 500), rng.uniform(-0.4, 0.3, 500))
    formula = Formula(Where("component", "strut", (0,)), terms)
    amplitudes = {f"formula.{term.name}_N": 100.0 for term in terms}
    file = tmp_path / "all.py"
    file.write_text(source_of(formula, amplitudes, "a campaign", "found-law"))
    kept = runpy.run_path(str(file))
    for term in terms:
        p = np.array([100.0, *term.shape])
        state = (-0.013, 0.21, 2e-4, 0.0, 1e-4, p)
        assert kept[term.kernel.__name__](*state) == term.kernel(*state)


def test_nothing_found_makes_a_page_too(tmp_path, capsys):
    page = tmp_path / "law.html"
    assert main(["law", str(campaign_of(tmp_path / "c")), "--report", str(page)]) == 0
    assert "Nothing to find: the model explains these runs" in page.read_text(encoding="utf-8")


def test_a_place_reads_as_a_sentence_has_it():
    assert Where("all struts", "strut", (0, 1, 2, 3)).in_words == "all struts"
    assert Where("rear tyres", "tyre", (2, 3)).in_words == "the rear tyres"


def test_a_name_that_is_no_python_file_is_refused_before_the_work(tmp_path, capsys):
    assert main(["law", str(tmp_path), "--save", str(tmp_path / "law.txt")]) == 2
    assert "end its name in .py" in capsys.readouterr().err
