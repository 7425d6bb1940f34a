"""Tables in many layouts, made by lot with known truth: each comes in right, or is asked about."""

import random

import numpy as np
import pytest

from tests.formats.foreign import G, save
from tests.formats.logged import drafted
from tests.formats.recordings import assert_same
from wheelhop.formats import draft_mapping
from wheelhop.formats import text as text_module

UNITS = {
    "g": G, "G": G, "m/s²": 1.0, "m/s^2": 1.0, "m/s/s": 1.0, "mg": G / 1e3, "mm": 1e-3,
    "lbs": 4.4482216152605, "in/s": 0.0254, "MPH": 0.44704, "Km/h": 1 / 3.6, "V": 1.0, "": 1.0,
    "deg/s": np.pi / 180, "%": 1.0, "furlong": 1.0, "N": 1.0, "kN": 1e3, "inch": 0.0254,
}  # fmt: skip
"""Units as loggers spell them, and what one is in the unit that a recording is kept in."""
NAMES = ("Acc FL", "acc hub RL", "A1", "Damper Pos", "GPS Speed", "Temp", "x", "ay", "Kraft", "u")
EPOCH = 1762640265.25
TIMES = (
    *(("Time", "s", 1), ("Time", "", 1), ("seconds", "", 1), ("X_Value", "", 1)),
    *(("t", "ms", 1000), ("Elapsed", "us", 10**6), ("timestamp", "ns", 10**9)),
    *(("time_ms", "", 1000), ("millis", "", 1000), ("Time since start in ms", "", 1000)),
    *(("time", "", -1), ("time", "", -(10**3)), ("unix", "us", -(10**6)), ("time", "", -(10**9))),
    *(("Zeit", "", "clock"), ("Datum", "", "date"), ("Time", "", "mm:ss")),
    *(("Time", "", 1000), ("x", "", 1), ("", "", 1)),
    *(("Sample", "", "count"), ("Nr.", "", "count"), ("frame", "", "odd count")),
)
"""Names of time, units that the file says, and the stamps: how many a second, or of which kind; a
negative number counts since 1970."""


STATED = (
    *("Sample rate: {hz:g} Hz", "# data_rate = {hz:g} Hz, filter = 488 Hz", "fs = {hz:g}Hz"),
    *("Sampling frequency (kHz): {khz:g}", "Sampling interval [ms]: {ms:g}", "dt = {s:g} s"),
    *("GPS sample rate: 10 Hz", "Max sample rate: 2000 Hz", "Sample rate divider: 10"),
    *("Data rate: 9600", "Sampling time: 30 s", "Sample rate (channel 2): {hz:g} Hz"),
)
"""Lines that state the table's rate, and, below, others that do not."""


class Lot:
    """One table and the truth about it."""

    def __init__(self, seed):
        pick = self.pick = random.Random(seed)
        self.separator = pick.choice([",", ";", "\t", "|", ";", ","])
        self.decimal = pick.choice([".", ","]) if self.separator != "|" else "."
        self.quoted = self.decimal == "," and self.separator == ","
        self.thousands = pick.choice(["", "", "", "." if self.decimal == "," else ","])
        self.quoted = self.quoted or self.thousands == self.separator
        self.rate_hz = pick.choice([10.0, 50.0, 100.0, 128.0, 200.0, 400.0, 1000.0, 2000.0])
        self.rows = pick.choice([20, 60, 300])
        self.channels = pick.randint(1, 5)
        self.names = pick.sample(NAMES, self.channels)
        self.units = [pick.choice(list(UNITS)) for _ in self.names]
        self.digits = pick.choice([3, 3, 4, 6])
        self.values = self._values()
        self.lost = self._lost()
        self.time, self.time_unit, self.stamps = pick.choice(TIMES)
        self.stated = pick.choice(["", *STATED, *STATED[:6]])
        self.own_clocks = self.time_unit == "s" and self.channels == 2 and pick.random() < 0.5
        self.text = self._text()

    def _values(self):
        """Samples, some channels beginning late or with cells that are empty, and some in whole
        numbers."""
        pick = self.pick
        values = np.empty((self.rows, self.channels))
        for k in range(self.channels):
            size = pick.choice([0.5, 5.0, 50.0, 5000.0])
            values[:, k] = [round(pick.uniform(-size, size), self.digits) for _ in range(self.rows)]
        for k in range(1, self.channels):
            kind = pick.choice(["all", "all", "all", "late", "some"])
            if kind == "late":
                values[: self.rows // 3, k] = np.nan
            if kind == "some":
                values[pick.randint(1, 4) :: pick.randint(2, 10), k] = np.nan
        return values

    def _lost(self):
        """Rows that were never written."""
        if self.pick.random() < 0.7:
            return set()
        first = self.pick.randint(5, self.rows - 8)
        return set(range(first, first + self.pick.randint(1, 3)))

    def _stamp(self, row):
        since, kind = row / self.rate_hz, self.stamps
        if "count" in str(kind):
            return str(row if kind == "count" else 2 * row)
        if kind in ("clock", "date", "mm:ss"):
            minutes, seconds = divmod(3595.0 + since, 60.0)
            hour, minute = divmod(int(minutes), 60)
            text = f"{seconds:09.6f}".replace(".", self.decimal)
            if kind == "mm:ss":
                return f"{minute:02}:{text}"
            return f"{'14.06.2025 ' if kind == 'date' else ''}{9 + hour:02}:{minute:02}:{text}"
        if kind < 0:  # since 1970
            return self._number((since + EPOCH) * -kind, 6) if kind == -1 else str(
                round(since * 1e6) * -kind // 10**6 + int(EPOCH * -kind)
            )  # fmt: skip
        return self._number(since * kind, 6 if kind == 1 else 3)

    def _number(self, value, digits=None):
        if np.isnan(value):
            return self.pick.choice(["", "", "NaN"])
        text = f"{value:.{self.digits if digits is None else digits}f}"
        whole, point, rest = text.partition(".")
        if self.thousands and digits is None:
            whole = f"{int(whole):,}".replace(",", self.thousands)
            whole = f"-{whole}" if text.startswith("-0") else whole
        return f"{whole}{self.decimal if point else ''}{rest}"

    def _text(self):
        pick, style = self.pick, self.pick.choice(["behind", "behind", "row", "brackets"])
        names = [*([self.time] if self.time else []), *self.names]
        units = [*([self.time_unit] if self.time else []), *self.units]
        if self.own_clocks:
            names.insert(2, f"{self.time} 2")
            units.insert(2, "s")
        lines = []
        if "count" in str(self.stamps) and self.stated:
            rates = {"hz": self.rate_hz, "khz": self.rate_hz / 1e3, "ms": 1e3 / self.rate_hz}
            lines.append(self.stated.format(**rates, s=1 / self.rate_hz))
        elif pick.random() < 0.4:
            lines.append(pick.choice(["Driver: A", "# made by a logger", '"Venue"', "Lap 3"]))
        if style == "row":
            lines += [names, units]
        else:
            form = {"behind": "{} ({})", "brackets": "{} [{}]"}[style]
            lines.append([form.format(n, u) if u else n for n, u in zip(names, units, strict=True)])
        if pick.random() < 0.2:
            lines.append("")
        for row in range(self.rows):
            if row in self.lost:
                continue
            stamp = [self._stamp(row)] if self.time else []
            lines.append([*stamp, *(self._number(value) for value in self.values[row])])
            if self.own_clocks:
                lines[-1].insert(2, self._number(row / self.rate_hz + 0.37, 6))
        if pick.random() < 0.2:
            lines += pick.choice([["", "End of file"], ["*** 3 laps ***"]])
        quote = '"' if self.quoted or pick.random() < 0.1 else ""
        tail = self.separator if pick.random() < 0.1 else ""
        written = (
            line if isinstance(line, str) else self.separator.join(quote + c + quote for c in line)
            + tail
            for line in lines
        )  # fmt: skip
        return "\n".join(written) + "\n"

    def wrong(self, found):
        """What is wrong with a recording, "" if nothing is."""
        if self.own_clocks or self.stamps == "odd count":
            return "of what must be asked about"
        due = np.array(self.values)
        if self.time:
            due[list(self.lost)] = np.nan
        else:
            due = np.delete(due, list(self.lost), axis=0)
        empty = [k for k in range(self.channels) if np.isnan(due[:, k]).all()]
        kept = [k for k in range(self.channels) if k not in empty]
        if abs(found.rate_hz / self.rate_hz - 1) > 1e-3:
            return f"{found.rate_hz} Hz, not {self.rate_hz}"
        if found.values.shape != (len(due), len(kept)):
            return f"{found.values.shape}, not {due.shape}"
        factors = [UNITS[self.units[k]] for k in kept]
        if not np.allclose(found.values, due[:, kept] * factors, 1e-9, 1e-12, equal_nan=True):
            return "other values"
        known = [bool(self.units[k]) and self.units[k] != "furlong" for k in kept]
        said = [channel.unit not in ("", "furlong") for channel in found.channels]
        return "" if said == known else "another unit"


def drawn(tmp_path, seeds):
    """How many tables came in, and what is wrong with any of these."""
    right, wrong, refused = 0, {}, {}
    for seed in seeds:
        lot = Lot(seed)
        found = drafted(tmp_path, lot.text)
        if isinstance(found, str):
            refused[seed] = found
        elif fault := lot.wrong(found):
            wrong[seed] = fault
        else:
            right += 1
    return right, wrong, refused


@pytest.mark.parametrize("part", range(4))
def test_a_table_comes_in_right_or_is_asked_about(part, tmp_path):
    right, wrong, refused = drawn(tmp_path, range(100 * part, 100 * part + 100))
    assert wrong == {}
    assert right >= 50, refused  # most tables say all that is needed


def test_large_files_are_read_as_small_ones_are(tmp_path, monkeypatch):
    """By pyarrow, or line by line where they are not plain: to the same bits."""
    bulk = 0
    for seed in range(150):
        text = Lot(seed).text
        monkeypatch.setattr("wheelhop.formats.bulk.LEAST_BYTES", 1 << 30)
        one = drafted(tmp_path, text)
        monkeypatch.setattr("wheelhop.formats.bulk.LEAST_BYTES", 0)
        with monkeypatch.context() as patched:
            tables = []
            patched.setattr(text_module, "_in_bulk", noting(tables, text_module._in_bulk))
            other = drafted(tmp_path, text)
        bulk += any(table is not None for table in tables)
        if isinstance(one, str):
            assert other == one
        else:
            assert_same(one, other)
    assert bulk >= 50


def noting(results, function):
    """The function, whose results are noted."""

    def noted(*arguments):
        results.append(function(*arguments))
        return results[-1]

    return noted


def test_of_a_large_file_both_ends_are_looked_at(tmp_path, monkeypatch):
    rows = [f"{k / 100:.2f};{k % 7}" for k in range(5000)]
    path = save(tmp_path, "run.csv", "\n".join(["Time [s];A1 [g]", *rows, "", "The end", ""]))
    whole = draft_mapping(path)
    monkeypatch.setattr("wheelhop.formats.cells.BEGIN_BYTES", 10_000)
    monkeypatch.setattr("wheelhop.formats.cells.END_BYTES", 1_000)
    assert draft_mapping(path) == whole
    assert "last_row = 5001  # below it: The end" in whole


@pytest.mark.slow
@pytest.mark.parametrize("part", range(8))
def test_thousands_of_tables_come_in_right_or_are_asked_about(part, tmp_path):
    right, wrong, _ = drawn(tmp_path, range(10_000 + 1000 * part, 11_000 + 1000 * part))
    assert wrong == {}
    assert right >= 500
