"""What is shown while the logger streams: codes and gaps, the clock's error, terminal and plot."""

import json
import os
import urllib.error
import urllib.parse
import urllib.request

import numpy as np
import pytest
from rich.console import Console

from tests.patience import PATIENCE_S
from wheelhop.cli.record_view import line, picture
from wheelhop.logger import LoggerError
from wheelhop.logger.block import pack_scans
from wheelhop.logger.clock import ClockEstimate
from wheelhop.logger.frames import Acknowledgement
from wheelhop.logger.live import Live, LivePlot

HEADER = {"rate_hz": "100", "conversions": "8", "channels": "B1 - - - - - - A4"}


@pytest.mark.parametrize("ppm", [-4000.0, 0.0, 87.0])
def test_the_clock_error_is_found_within_what_it_says(ppm):
    rng = np.random.default_rng(5)
    estimate = ClockEstimate(100.0)
    for number in range(60 * 100):
        late = 40 if number > 3000 else 0
        logger_s = number / 100 + late * 156.25e-6
        delay_s = 1e-3 + rng.exponential(4e-3)
        estimate.add(number, 7.0 + logger_s * (1 + ppm * 1e-6) + delay_s, late)
    found = estimate.result()
    assert found.is_sound and abs(found.ppm - ppm) < 4 * found.deviation_ppm
    assert found.deviation_ppm < 5.0


def test_a_clock_of_another_kind_is_not_believed():
    estimate = ClockEstimate(100.0)
    for number in range(3000):
        estimate.add(number, number / 2000)
    assert not estimate.result().is_sound
    assert ClockEstimate(100.0).result() is None


def live_of_a_recording():
    live = Live()
    live.describe({**HEADER, "supply_mv": "3300"})
    for number in range(200):
        live.add(number / 100, pack_scans([[4096, 8 * number]]), missing=number == 150)
    return live


def test_gaps_are_seen_and_not_filled():
    live = live_of_a_recording()
    count, codes = live.after(0)
    assert count == 201 and np.isnan(codes[150]).all() and np.isfinite(codes[151:]).all()
    assert codes[10].tolist() == [512.0, 10.0] and len(live.window(1.0)) == 99
    assert live.measured_rate_hz() == pytest.approx(100.0)


def test_the_view_names_what_a_user_must_know():
    live = live_of_a_recording()
    live.written, live.lost = 200, 1
    live.told = Acknowledgement(0x10001, 6, 201, 185, 0, 0, 250, 40, 0)
    console = Console(width=100, record=True, file=open(os.devnull, "w"))  # noqa: SIM115
    console.print(picture(live))
    text = console.export_text()
    for word in ("B1", "A4", "missing 1", "3.30 V", "100 scans/s", "stall 250 ms", "512.0"):
        assert word in text
    assert "200 scans, 1 missing; 100.0 Hz; 185 scans safe" in line(live)


def test_the_plot_comes_from_this_computer_alone():
    live = live_of_a_recording()
    with LivePlot(live) as plot:
        assert plot.url.startswith("http://127.0.0.1:")
        page = urllib.request.urlopen(plot.url, timeout=PATIENCE_S).read().decode()
        assert "http" not in page.replace("http-equiv", "") and "EventSource" in page
        with urllib.request.urlopen(plot.url + "events", timeout=PATIENCE_S) as stream:
            told = json.loads(stream.readline().removeprefix(b"data: "))
        assert told["channels"] == ["B1", "A4"] and told["missing"] == 0
        assert told["codes"][150] is None and told["codes"][10] == [512.0, 10.0]
        with pytest.raises(urllib.error.HTTPError):
            urllib.request.urlopen(plot.url + "etc", timeout=PATIENCE_S)
        with pytest.raises(LoggerError, match="take another"):
            LivePlot(live, urllib.parse.urlsplit(plot.url).port)
