"""What is said while the computer works: never silence for long, and how long it still takes."""

import re

from wheelhop.cli import progress
from wheelhop.cli.progress import TimeLeft, stages


def test_time_left_is_what_the_rate_so_far_says():
    left = TimeLeft()
    assert left.words("reading", 0.0) == left.words("20 of 200 points", 5.0) == ""
    assert left.words("30 of 200 points", 15.0) == ", about 2:50 left"
    assert left.words("screening", 16.0) == ""
    assert left.words("40 of 200 points", 20.0) == ", about 2:00 left"
    assert left.words("200 of 200 points", 99.0) == ""
    assert left.words("1 of 4", 100.0) == ""  # another stage begins
    assert left.words("2 of 4", 4000.0) == ", about 2:10:00 left"


def test_without_a_terminal_lines_come_at_a_readable_pace(capsys, monkeypatch):
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    with stages() as say:
        for second in range(60):
            now[0] = float(second)
            say(f"fitting, {second} of 60")
    lines = capsys.readouterr().err.splitlines()
    assert 4 <= len(lines) <= 6
    assert all(re.fullmatch(r"wheelhop: 0:\d\d fitting, \d+ of 60, .* left", x) for x in lines)
    with stages() as say:
        say("a moment")
    assert capsys.readouterr().err == ""
