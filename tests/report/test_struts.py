"""What the struts did: measured on a car that shares no code, and as its fitted model has it."""

import numpy as np
import pytest

import wheelhop as wh
from tests import truth
from tests.truth.sensors import SENSORS, Sensor
from wheelhop.compare import InBand
from wheelhop.report.sections import struts as section
from wheelhop.report.strut_figures import farthest_run, histograms_figure, strut_loops_figure
from wheelhop.report.strut_motion import _strut_run, shares, strut_histories

POT_NOISE = 2e-4 / 0.65


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """A linear car with four pots and one push-rod gauge, and its baseline."""
    folder = truth.make_campaign(
        tmp_path_factory.mktemp("pots") / "c",
        seed=5,
        effects={},
        short=True,
        seconds=4.0,
        draft=True,
        sensors=(*SENSORS, Sensor("rod1", "force", "1", 8.0, -1.4, 300.0)),
    )
    return wh.compare(folder)


@pytest.fixture(scope="module")
def histories(fitted):
    return strut_histories(fitted.campaign, fitted.steps)


def test_a_sine_spends_its_time_as_its_velocity_says():
    """|v| < v0 for 2 / π · asin(v0 / V) of the time, half of it in bump."""
    phase = np.linspace(0.0, 2 * np.pi, 100_000, endpoint=False)
    found = shares(0.2 * np.sin(phase))
    low = np.arcsin(0.05 / 0.2) / np.pi
    assert found.bump_low == pytest.approx(low, abs=1e-4)
    assert found.rebound_low == pytest.approx(low, abs=1e-4)
    assert found.bump_high == pytest.approx(0.5 - low, abs=1e-4)
    assert sum(vars(found).values()) == pytest.approx(1.0)


def test_shortening_is_bump():
    assert shares(np.full(10, -0.2)).bump_high == 1.0
    assert shares(np.full(10, 0.01)).rebound_low == 1.0


def test_velocity_is_that_of_travel_up_to_the_ends():
    """Travel that ends elsewhere than it began overshoots there, and only there."""
    rate_hz, count = 100.0, 1000
    time_s = np.arange(count) / rate_hz
    travel, omega = 0.01 * np.sin(2 * np.pi * 2.23 * time_s), 2 * np.pi * 2.23
    band = InBand(count, rate_hz, (0.5, 30.0))
    found = _strut_run(band, band.coefficients(travel), None)
    kept = slice(50, -50)
    assert len(found.travel) == len(travel[kept])
    expected = 0.01 * omega * np.cos(omega * time_s)
    wrong = found.velocity - expected[kept]
    assert np.abs(wrong).max() < 0.1 * 0.01 * omega
    whole = band.from_coefficients(band.differentiated(band.coefficients(travel)))
    assert np.abs(whole - expected).max() > 0.5 * 0.01 * omega


def test_a_right_model_leaves_the_noise_of_the_sensors(histories):
    """Of travel, of velocity as it is said to be enlarged, and of the force."""
    for measured, modelled in histories.values():
        travel = measured.travel - modelled.travel
        assert travel.std() == pytest.approx(POT_NOISE, rel=0.15)
        velocity = measured.velocity - modelled.velocity
        assert velocity.std() == pytest.approx(measured.velocity_noise, rel=0.15)
        assert modelled.velocity_noise == 0.0
    gauged = histories[0][0].runs
    modelled = histories[0][1].runs
    force = np.concatenate([gauged[run].force - modelled[run].force for run in gauged])
    assert force.std() == pytest.approx(8.0 / 1.4, rel=0.2)
    assert all(run.force is None for run in histories[1][0].runs.values())


def test_what_is_drawn(fitted, histories):
    """A grey area where travel was measured, and a line of a measured force."""
    figure = histograms_figure(histories)
    assert len(figure.axes) == 2 * len(histories)
    share = sum(patch.get_data().values.sum() for patch in figure.axes[0].patches[:2])
    assert share == pytest.approx(200.0)
    loops = strut_loops_figure(histories, fitted.model)
    lines = [[line.get_label() for line in axes.lines] for axes in loops.axes[::2]]
    assert lines == [["measured", "baseline"], *[["baseline"]] * 3]
    spring = loops.axes[1].lines[1]
    c = fitted.model.values["suspension.front.damping_N_s_m"]
    x, y = spring.get_data()
    assert np.polyfit(1e-3 * x, y, 1)[0] == pytest.approx(c, rel=0.02)
    assert farthest_run(histories[0][0]) in fitted.campaign.to_dataframe().index


def test_they_stand_in_report_and_table(fitted):
    found = section(fitted.campaign, fitted.steps)
    assert "What the struts did" in found and "of it noise" in found
    table = fitted.struts()
    assert list(table.loc["rear left"].index) == ["measured", "baseline"]
    parts = ["bump_high", "bump_low", "rebound_low", "rebound_high"]
    np.testing.assert_allclose(table[parts].sum(axis=1), 1.0)


def test_without_potentiometers_the_model_alone_is_shown(friction):
    steps = friction.diagnosis.ladder
    found = strut_histories(friction.campaign, steps)
    assert [h.name for h in found[3]] == ["baseline", "last model"]
    assert "noise" not in section(friction.campaign, steps)
