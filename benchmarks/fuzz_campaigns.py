"""Degenerate campaigns through a command: python -m benchmarks.fuzz_campaigns --cases 2000
and, slower, python -m benchmarks.fuzz_campaigns --command diagnose --cases 200

A short campaign in which one to three things are changed into what nobody would record: channels
that rest, tiny and huge numbers, bands without a bin, titles of control characters. A case is well
if the command ends in a result or in one line and exit code 2.
"""

import argparse
import contextlib
import io
import re
import shutil
import sys
import tempfile
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.write import NewRun, add_run, new_campaign
from wheelhop.cli.main import main as wheelhop
from wheelhop.logger.recording import Channel, Recording

ROWS, RATE_HZ = 256, 100.0
POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
MORE = {"diagnose": ("--max-effects", "1")}
TRACK: dict[str, str | float] = {"kind": "washboard", "amplitude_mm": 15, "pitch_mm": 400}
Rng = np.random.Generator
NUMBERS = ("0", "-1", "1e-300", "1e-12", "1e12", "1e300", "nan", "inf", "9007199254740993", "true")
TEXTS = ('""', '"\\u0000"', '"a\\nb"', '"\\"\'"', '"' + "k" * 2_000_000 + '"', '"\\u202e"', '" "')


def main() -> int:
    """Run the cases, print those that are not well; exit code 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    parser.add_argument("--command", choices=("check", "compare", "diagnose"), default="compare")
    arguments = parser.parse_args()
    bad, ended = 0, {0: 0, 2: 0}
    with tempfile.TemporaryDirectory() as place:
        pattern = make_pattern(Path(place) / "pattern")
        for case in range(arguments.first, arguments.first + arguments.cases):
            changes, code, complaint = try_case(
                pattern, Path(place) / "case", case, arguments.command
            )
            ended[code] = ended.get(code, 0) + 1
            if complaint:
                bad += 1
                print(f"case {case} ({', '.join(changes)}): {complaint}", flush=True)
    print(f"{arguments.cases} cases: {ended[0]} with a result, {ended[2]} refused, {bad} not well")
    return 1 if bad else 0


def make_pattern(folder: Path) -> Path:
    """The campaign that cases change: a run to fit and one to judge."""
    rng = np.random.default_rng(1)
    channels = tuple(Channel(point, "m/s²") for point in POINTS)
    for i, role in enumerate(("fit", "validate")):
        time_s = np.arange(ROWS) / RATE_HZ
        wave = np.sin(2 * np.pi * 5.2 * time_s[:, None] + rng.uniform(0, 6, len(POINTS)))
        values = 3 * wave + rng.normal(0.0, 0.1, (ROWS, len(POINTS)))
        recording = Recording(values, RATE_HZ, channels, averaging_s=0.01)
        if i == 0:
            new_campaign(folder, "pattern", recording, {})
        add_run(folder, recording, NewRun(id=role, role=role, speed_kmph=7.5, track=TRACK))
    return folder


def try_case(
    pattern: Path, folder: Path, case: int, command: str = "compare"
) -> tuple[list[str], int, str]:
    """What was changed, the exit code, and what is wrong with how it ended ("" if nothing is)."""
    rng = np.random.default_rng(case)
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(pattern, folder)
    chosen = rng.choice(len(CHANGES), rng.integers(1, 4), replace=False)
    for i in chosen:
        CHANGES[i](folder, rng)
    names = [CHANGES[i].__name__ for i in chosen]
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("always")
                warnings.filterwarnings("ignore", "First-class function type feature")
                code = wheelhop([command, str(folder), *MORE.get(command, ())])
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1
        except Exception as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            return names, 1, f"{type(error).__name__}: {error!s:.80} ({place.name}:{place.lineno})"
    said = err.getvalue().splitlines()
    lines = [line for line in said if not re.match(r"wheelhop: \d+:\d\d |compiling ", line)]
    if code not in (0, 2):
        return names, code, f"exit code {code}"
    if code == 2 and (len(lines) != 1 or len(lines[0]) > 4096):
        return names, code, f"{len(lines)} lines of {len(err.getvalue())} characters"
    if code == 0 and lines:
        return names, code, f"says beside its result: {lines[0]:.120}"
    return names, code, ""


def _run_file(folder: Path, rng: Rng) -> Path:
    return sorted((folder / "runs").glob("*.csv"))[rng.integers(2)]


def _columns(folder: Path, rng: Rng, change: Callable[[NDArray[np.float64]], object]) -> None:
    """Change the channels (rows, 8) of one recording."""
    file = _run_file(folder, rng)
    head, *rows = file.read_text().splitlines()
    values = np.array([[float(word) for word in row.split(",")] for row in rows])
    change(values[:, 1:])
    lines = [head, *(",".join(f"{x:.17g}" for x in row) for row in values)]
    file.write_text("\n".join(lines) + "\n")


def rest(folder: Path, rng: Rng) -> None:
    """Channels that never move."""
    which = rng.choice(8, rng.integers(1, 9), replace=False)
    level = rng.choice([0.0, 9.81, 1e-300])
    _columns(folder, rng, lambda v: v.__setitem__((slice(None), which), level))


def scale(folder: Path, rng: Rng) -> None:
    """Channels far too small or large."""
    which = rng.choice(8, rng.integers(1, 9), replace=False)
    factor = rng.choice([1e-300, 1e-160, 1e-12, 1e12, 1e160, 1e300])
    _columns(folder, rng, lambda v: v.__setitem__((slice(None), which), v[:, which] * factor))


def copy(folder: Path, rng: Rng) -> None:
    """All channels the same."""
    _columns(folder, rng, lambda v: v.__setitem__(slice(None), v[:, :1].copy()))


def spike(folder: Path, rng: Rng) -> None:
    """One sample alone."""

    def alone(values: NDArray[np.float64]) -> None:
        values[:] = 0.0
        values[rng.integers(len(values)), 0] = 1e3

    _columns(folder, rng, alone)


def shorten(folder: Path, rng: Rng) -> None:
    """A few rows."""
    file = _run_file(folder, rng)
    kept = int(rng.integers(1, ROWS))
    file.write_text("".join(file.read_text().splitlines(keepends=True)[: kept + 1]))


def number(folder: Path, rng: Rng) -> None:
    """A number of either file replaced."""
    _replace(folder, rng, NUMBERS, lambda value: value[:1] in "0123456789-")


def text(folder: Path, rng: Rng) -> None:
    """A text of either file replaced."""
    _replace(folder, rng, TEXTS, lambda value: value[:1] == '"')


def band(folder: Path, rng: Rng) -> None:
    """A band of few frequencies, or of none."""
    low = float(rng.choice([1e-9, 1.0, 1.0001, 5.1, 49.0]))
    high = low + float(rng.choice([1e-9, 1e-3, 0.2, 0.9]))
    file = folder / "campaign.toml"
    lines = file.read_text().splitlines()
    lines = [f"band_hz = [{low!r}, {high!r}]" if x.startswith("band_hz") else x for x in lines]
    file.write_text("\n".join(lines) + "\n")


def _replace(folder: Path, rng: Rng, values: tuple[str, ...], fits: Callable[[str], bool]) -> None:
    file = folder / str(rng.choice(["campaign.toml", "vehicle.toml"]))
    lines = file.read_text().splitlines()
    places = [i for i, x in enumerate(lines) if " = " in x and fits(x.split(" = ", 1)[1])]
    i = int(rng.choice(places))
    lines[i] = f"{lines[i].split(' = ', 1)[0]} = {values[rng.integers(len(values))]}"
    file.write_text("\n".join(lines) + "\n")


CHANGES = (rest, scale, copy, spike, shorten, number, text, band)

if __name__ == "__main__":
    sys.exit(main())
