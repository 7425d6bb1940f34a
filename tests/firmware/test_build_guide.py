"""firmware/BUILD.md says what is computed, adds up, and shows what the program judges."""

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.calibration.strikes import POINTS, struck
from wheelhop.calibration.health.checklist import check_commissioning
from wheelhop.logger.block import scans_per_block

ROOT = Path(__file__).parents[2]
BUILD = (ROOT / "firmware/BUILD.md").read_text(encoding="utf-8")
README = (ROOT / "firmware/README.md").read_text(encoding="utf-8")
GIVEN_UP_MS = 2000  # the firmware takes a card for dead that is busy for longer


@pytest.fixture
def numbers(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    import build_numbers

    return build_numbers


@pytest.fixture
def drawings(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    import make_build_drawings

    return make_build_drawings


def rows(text, heading):
    """The cells of the table below a line that begins like this."""
    lines = text[text.index(heading) :].splitlines()[2:]
    end = next(k for k, line in enumerate(lines) if not line.startswith("|"))
    return [[cell.strip(" *") for cell in line.strip("|").split("|")] for line in lines[:end]]


def test_the_pages_figures_are_the_computed_ones(numbers):
    absent = {
        name: value
        for name, value in numbers.numbers().items()
        if not re.search(rf"(?<![\d.]){re.escape(value)}(?!\d)", BUILD)
    }
    assert absent == {}


def test_filters_and_mounts_are_those_of_textbooks(numbers):
    """−3 dB at the corner; a box of 10 ms has its first zero at 100 Hz; a thin strip is softer."""
    assert numbers.left_dB(1e-3, 100) == pytest.approx(0.0, abs=1e-6)
    assert numbers.left_dB(50.0, 400, 50.0) == pytest.approx(3.01, abs=0.01)
    assert numbers.left_dB(100.0, 100) > 30
    # sinc(0.6) and a filter of first order at 1.2 times its corner: 9.8 dB for a mean without gaps.
    least, most = map(float, re.findall(r"[\d.]+", numbers.line_left(100)))
    assert least < 9.8 < most
    # 3·E·I/L³ = 147.7 kN/m at 20 g.
    assert numbers.bracket_hz(0.04, 0.02, 0.003, 0.02) == pytest.approx(432.4, abs=0.1)


def test_the_bill_adds_up():
    *parts, total = rows(BUILD, "| part | from | to |")
    assert total[0] == "total" and len(parts) >= 10
    for column in (1, 2):
        assert sum(int(part[column]) for part in parts) == int(total[column])
    sensors = next(part for part in parts if "ADXL326" in part[0])
    assert int(sensors[1]) / int(total[1]) == pytest.approx(0.4, abs=0.03)


def test_no_stall_is_promised_that_memory_cannot_hold():
    """All blocks are free when a stall begins: the measured figures lie just below that."""
    blocks = {"Nano": 2, "Mega": 8}
    for name, *stalls in rows(README, "| board, channels |"):
        board, channels = name.split(",")[0], int(name.split(",")[1])
        for rate, stall in zip((100, 200, 400), stalls, strict=True):
            room_ms = 1000 * blocks[board] * scans_per_block(channels) / rate
            room_ms = min(room_ms, GIVEN_UP_MS)
            assert room_ms - 10 <= int(stall) <= room_ms + 1000 / rate


def test_drawings_are_those_of_their_program(drawings):
    for name, draw in drawings.DRAWN.items():
        made = draw().svg()
        ElementTree.fromstring(made)
        assert (ROOT / "firmware/drawings" / name).read_text(encoding="utf-8") == made, (
            "run docs/make_build_drawings.py"
        )


def test_the_printed_sheet_has_the_steps_that_are_judged(drawings):
    steps = [check.step for check in check_commissioning(struck(0))]
    assert [title for title, _ in drawings.JUDGED] == steps
    assert any("  ".join(POINTS) in line for line in drawings.THE_SESSION)
