"""The whole comparison: error, charge, tables, JSON, screen."""

import io
import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

from tests.compare.conftest import Bench
from wheelhop.compare import compare, in_band, print_comparison, relative_error, to_json

SPEEDS = [2.0, 3.1, 2.6, 4.2]


@pytest.fixture
def tested(bench):
    return bench.campaign(SPEEDS, lambda t, v: bench.noise(0.3) + 0.1 * bench.motion(t, v))


def scaled(campaign, responses, factor):
    runs = tuple(replace(r, record=factor * r.record) for r in campaign.runs)
    noise = campaign.noise_rms and abs(factor) * campaign.noise_rms
    return (
        replace(campaign, runs=runs, noise_rms=noise),
        [replace(r, record=factor * r.record) for r in responses],
    )


def test_error_is_pooled_over_runs_and_channels_of_one_role(tested):
    campaign, responses = tested
    residual = measured = 0.0
    for run, response in zip(campaign.runs[1:], responses[1:], strict=True):
        # By hand: a plain discrete Fourier transform, bins of 0.5 to 30 Hz.
        k = np.arange(6, 308)[:, None] * np.arange(1024) / 1024
        transform = np.exp(-2j * np.pi * k)
        residual += np.sum(np.abs(transform @ (run.record - response.record)) ** 2)
        measured += np.sum(np.abs(transform @ run.record) ** 2)
    assert compare(campaign, responses).error_validate == pytest.approx(
        np.sqrt(residual / measured)
    )


@settings(max_examples=10, deadline=None)
@given(st.floats(1e-3, 1e3), st.sampled_from([-1.0, 1.0]))
def test_units_do_not_matter_to_error_and_floor(size, sign):
    bench = Bench()
    tested = bench.campaign(SPEEDS, lambda t, v: bench.noise(0.3))
    once, other = compare(*tested), compare(*scaled(*tested, sign * size))
    assert other.error_fit == pytest.approx(once.error_fit)
    assert other.floor.error == pytest.approx(once.floor.error)
    assert other.breakdown.growth == pytest.approx(once.breakdown.growth, nan_ok=True)


def test_permuting_the_channels_permutes_the_table(tested):
    campaign, responses = tested
    order = np.array([3, 0, 7, 2, 5, 1, 6, 4])
    runs = tuple(replace(r, record=r.record[:, order]) for r in campaign.runs)
    other = replace(campaign, runs=runs, channels=tuple(campaign.channels[i] for i in order))
    permuted = [replace(r, record=r.record[:, order]) for r in responses]
    once, again = compare(campaign, responses), compare(other, permuted)
    assert again.error_validate == pytest.approx(once.error_validate)
    np.testing.assert_allclose(
        again.breakdown.runs_channels.ratio, once.breakdown.runs_channels.ratio[:, order]
    )
    shares = {part.name: part.share for part in once.breakdown.motion}
    for part in again.breakdown.motion:
        assert part.share == pytest.approx(shares[part.name])


def test_charged_degrees_of_freedom_raise_the_error_as_least_squares_lowers_it(bench):
    # Fitting q free numbers to noise lowers its sum of squares by q/n; the charge restores it.
    q, n = 200, 604 * 8
    campaign, responses = bench.campaign([2.0, 3.0], lambda t, v: bench.noise(0.3))
    records = in_band(campaign, responses)
    plain, charged = relative_error(records[1:]), relative_error(records[1:], {"run-1": q})
    assert charged == pytest.approx(plain * np.sqrt(n / (n - q)))
    comparison = compare(campaign, responses, {"run-1": q})
    assert comparison.error_validate == pytest.approx(charged)
    assert comparison.error_fit == pytest.approx(relative_error(records[:1]))
    with pytest.raises(ValueError, match="run-1"):
        compare(campaign, responses, {"run-1": n})


def test_a_quiet_run_does_not_disturb_the_rest(bench):
    def motion(time, speed):
        return bench.motion(time, speed) * (1e-3 if speed == SPEEDS[-1] else 1.0)

    campaign, responses = bench.campaign(SPEEDS, lambda t, v: bench.noise(0.1), motion=motion)
    loud = relative_error(in_band(campaign, responses)[1:3])
    assert compare(campaign, responses).error_validate == pytest.approx(loud, rel=0.3)


def test_a_role_without_runs_has_no_error_and_json_says_null(bench):
    campaign, responses = bench.campaign([2.0, 3.0], lambda t, v: bench.noise(0.1))
    written = to_json(compare(campaign, responses[:1]))
    assert written["error_validate"] is None
    assert written["error_fit"] > 0.0


def test_json_is_plain_and_complete(tested):
    campaign, responses = tested
    for response in responses:
        response.record[:, 2] = np.nan
    comparison = compare(replace(campaign, noise_rms=None), responses)
    written = json.loads(json.dumps(to_json(comparison), allow_nan=False))
    assert written["floor"]["source"] == "estimated"
    assert written["floor"]["noise_rms_m_s2"]["b3"] is None
    pooled = np.hypot(written["error_fit"], written["error_validate"])
    assert written["where"]["ratio_to_floor"] > 1.0
    assert pooled > written["floor"]["error"] > 0.0
    assert len(written["figures"]) == 7 * len(SPEEDS)
    assert set(written["figures"][0]["rating"]) == {
        "corridor", "phase", "magnitude", "slope", "overall",
    }  # fmt: skip
    where = written["where"]
    assert {"run", "channel", "band_hz", "motion", "time", "amplitude", "locking"} <= set(where)
    assert where["run_channel_ratio"]["run-1"]["b3"] is None
    assert where["description"]


def test_a_response_that_does_not_fit_is_refused(tested):
    campaign, responses = tested
    with pytest.raises(ValueError, match="no run 'other'"):
        compare(campaign, [replace(responses[0], run_id="other")])
    with pytest.raises(ValueError, match="does not fit"):
        compare(campaign, [replace(responses[0], record=np.zeros((1024, 3)))])
    responses[0].record[5, 1] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        compare(campaign, responses)
    with pytest.raises(ValueError, match="no response"):
        compare(campaign, [])
    nothing = np.full_like(responses[0].record, np.nan)
    with pytest.raises(ValueError, match="no response"):
        compare(campaign, [replace(responses[0], record=nothing)])


def test_the_screen_shows_errors_floor_and_every_run(tested):
    screen = io.StringIO()
    comparison = compare(*tested)
    print_comparison(comparison, Console(file=screen, width=80))
    text = screen.getvalue()
    assert f"{100 * comparison.error_validate:.2f} %" in text
    assert f"{100 * comparison.floor.error_fit:.2f} %" in text
    assert all(run.id in text for run in tested[0].runs)
    assert max(len(line) for line in text.splitlines()) <= 80
