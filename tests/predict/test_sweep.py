"""Sweeps: every combination once, whatever ends the program in between."""

import contextlib
import errno
import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.patience import PATIENCE_S, wait_until
from wheelhop.campaign import CampaignError
from wheelhop.cli.main import main
from wheelhop.predict.journal import run_sweep
from wheelhop.predict.ride import ride
from wheelhop.predict.sweep import Axis, Sweep
from wheelhop.predict.trouble import Trouble, lasting
from wheelhop.vehicle import read_vehicle

FILE = Path(__file__).parents[2] / "examples/clean/vehicle.toml"
VEHICLE = read_vehicle(FILE)


def sweep(*axes, effects=(), kind=Sweep):
    parsed = tuple(Axis.parse(text) for text in axes)
    return kind(VEHICLE, ("washboard/low",), (9.0,), effects, parsed, seconds=2.0, seed=0)


def test_points_are_every_combination_the_last_axis_fastest():
    one = sweep("speed=8:10:2", "body.mass_kg=200:240:3")
    points = [tuple(one.point(number).values()) for number in range(len(one))]
    assert points == [(v, m) for v in (8.0, 10.0) for m in (200.0, 220.0, 240.0)]


def test_a_point_is_the_run_it_says(tmp_path):
    one = sweep("speed=8:10:2", "dry-friction.front_N=0:50:2", effects=("dry-friction:rear_N=0",))
    _, rows = run_sweep(one, tmp_path / "t.parquet", ThreadPoolExecutor(2))
    assert pq.read_table(tmp_path / "t.parquet").to_pylist() == rows
    assert [path.name for path in tmp_path.iterdir()] == ["t.parquet"]
    last = one.case(3)
    assert last.drives[0].speed_kmph == 10.0 == rows[3]["speed_kmph"]
    assert last.nominal.values["dry-friction.front_N"] == 50.0 == rows[3]["dry-friction.front_N"]
    assert rows[3]["travel_front_rms_m"] == ride(last, 0).travel_front_rms_m
    assert rows[3]["travel_front_rms_m"] != rows[2]["travel_front_rms_m"]


def test_a_run_without_result_says_why_and_stops_nothing(tmp_path):
    one = sweep("anti-roll-bar.front_N_m=0:1e9:2", effects=("anti-roll-bar",))
    _, (good, bad) = run_sweep(one, tmp_path / "t.parquet", ThreadPoolExecutor(1))
    assert good["problem"] == "" and good["dynamic_load_front"] > 0.0
    assert "runs away" in bad["problem"] and bad["dynamic_load_front"] is None


MISTAKES = {
    "speed 0": ("speed=0:10:3", "must be above 0"),
    "negative mass": ("body.mass_kg=-10:200:3", "must be greater than 0"),
    "beyond the axles": ("geometry.cg_to_front_axle_m=0.5:3:2", "must be less than wheelbase"),
    "no such number": ("body.mas_kg=1:2:2", "did you mean 'body.mass_kg'"),
    "not among the effects": ("dry-friction.front_N=1:2:2", "no number dry-friction.front_N"),
    "no grid": ("speed=8:10", "NAME=FIRST:LAST:COUNT"),
    "not finite": ("speed=8:inf:3", "NAME=FIRST:LAST:COUNT"),
    "too many": ("speed=8:10:9999999", "NAME=FIRST:LAST:COUNT"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_a_mistake_is_one_line(case, tmp_path, capsys):
    words, complaint = MISTAKES[case]
    out = ["--out", str(tmp_path / "t.parquet")]
    tracks = ["--tracks", "washboard/low"]
    assert main(["simulate", str(FILE), *tracks, "--sweep", words, *out]) == 2
    error = capsys.readouterr().err
    assert complaint in error and error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_another_sweep_does_not_touch_a_table(tmp_path):
    table = tmp_path / "t.parquet"
    run_sweep(sweep("speed=8:10:2"), table, ThreadPoolExecutor(1))
    before = table.read_bytes()
    with pytest.raises(CampaignError, match="not of this sweep"):
        run_sweep(sweep("speed=8:11:2"), table, ThreadPoolExecutor(1))
    assert table.read_bytes() == before


class Counted(Sweep):
    """Counts instead of simulating."""

    asked: list[int]

    def rows(self, number):
        self.asked.append(number)
        return [{"run": "x", "speed_kmph": float(number), "problem": ""}]


@settings(max_examples=20, deadline=None)
@given(st.floats(0.0, 1.0), st.integers(0, 9))
def test_a_journal_cut_anywhere_goes_on_with_what_is_whole(share, points):
    one = sweep("speed=8:10:10", kind=Counted)
    with TemporaryDirectory() as folder:
        table = Path(folder) / "t.parquet"
        journal = table.with_name("t.parquet.journal")
        lines = [json.dumps({"sweep": one.fingerprint})]
        lines += [json.dumps({"point": i, "rows": one_row(i)}) for i in range(points)]
        data = "".join(f"{line}\n" for line in lines).encode()
        cut = data[: round(share * len(data))]
        journal.write_bytes(cut)
        whole = max(cut.count(b"\n") - 1, 0)
        object.__setattr__(one, "asked", [])
        computed, rows = run_sweep(one, table, ThreadPoolExecutor(1))
    assert computed == len(one.asked) == 10 - whole
    assert sorted(one.asked) == list(range(whole, 10))
    assert [row["speed_kmph"] for row in rows] == list(map(float, range(10)))


def one_row(number):
    return [{"run": "x", "speed_kmph": float(number), "problem": ""}]


class Fragile(ThreadPoolExecutor):
    """Loses its process at the second point."""

    def submit(self, function, number):
        def work():
            if number == 1:
                raise BrokenExecutor
            return function(number)

        return super().submit(work)


def test_a_lost_worker_is_one_line_and_loses_nothing(tmp_path):
    one = sweep("speed=8:10:3", kind=Counted)
    object.__setattr__(one, "asked", [])
    with pytest.raises(CampaignError, match="goes on from here"):
        run_sweep(one, tmp_path / "t.parquet", Fragile(1))
    assert [path.name for path in tmp_path.iterdir()] == ["t.parquet.journal"]
    _, rows = run_sweep(one, tmp_path / "t.parquet", ThreadPoolExecutor(1))
    assert [row["speed_kmph"] for row in rows] == [0.0, 1.0, 2.0]


class Troubled(Counted):
    """Point 1 meets what its subclass says."""

    def rows(self, number):
        if number == 1 and Troubled.what is not None:
            raise Troubled.what
        return super().rows(number)


@pytest.mark.parametrize(
    "what", [OSError(errno.ESTALE, "Stale file handle"), MemoryError(), Trouble("try again")]
)
def test_trouble_that_may_pass_is_no_result(what, tmp_path, monkeypatch):
    one, table = sweep("speed=8:10:3", kind=Troubled), tmp_path / "t.parquet"
    object.__setattr__(one, "asked", [])
    monkeypatch.setattr(Troubled, "what", what, raising=False)
    with pytest.raises(CampaignError, match=r"1 of 3 points.*speed = 9.*goes on from here"):
        run_sweep(one, table, ThreadPoolExecutor(1))
    assert one.asked == [0, 2] and not table.exists()
    monkeypatch.setattr(Troubled, "what", None)
    computed, rows = run_sweep(one, table, ThreadPoolExecutor(1))
    assert computed == 1 and [row["speed_kmph"] for row in rows] == [0.0, 1.0, 2.0]


def test_a_refusal_of_the_system_may_pass_and_a_file_that_is_not_there_does_not():
    for code in (errno.EIO, errno.EACCES, errno.ENOSPC, errno.ESTALE, errno.EMFILE):
        with pytest.raises(Trouble):
            lasting(OSError(code, "no"), "here")
    for error in (OSError(errno.ENOENT, "no"), ValueError("no"), OSError("no Parquet")):
        assert lasting(error, "here").startswith("here: ")
    assert lasting(CampaignError("there: wrong"), "here") == "there: wrong"
    try:
        try:
            raise OSError(errno.EIO, "Input/output error")
        except OSError:
            raise CampaignError("x.csv: cannot be read: Input/output error") from None
    except CampaignError as error:
        with pytest.raises(Trouble, match=r"x\.csv"):
            lasting(error, "here")


def test_a_sweep_is_the_same_however_its_survey_is_spelt(tmp_path, monkeypatch):
    (tmp_path / "road.csv").write_text("x_m,left_m,right_m\n0,0,0\n5,0,0\n9,0.01,0.01\n")
    (tmp_path / "link.csv").symlink_to("road.csv")
    monkeypatch.chdir(tmp_path)
    axes = (Axis.parse("speed=8:10:2"),)
    spelt = ("road.csv", "./road.csv", str(tmp_path / "road.csv"), "link.csv")
    made = [
        Sweep(VEHICLE, (f"profile:file={path}",), (), (), axes, seconds=2.0, seed=0)
        for path in spelt
    ]
    assert len({one.fingerprint for one in made}) == 1
    before = made[0].fingerprint
    (tmp_path / "road.csv").write_text("x_m,left_m,right_m\n0,0,0\n5,0,0\n9,0.02,0.01\n")
    assert made[0].fingerprint != before


def test_killed_it_goes_on_and_computes_nothing_twice(tmp_path):
    """A real SIGKILL, while the command and its processes are at work."""
    table, journal = tmp_path / "t.parquet", tmp_path / "t.parquet.journal"
    words = ["simulate", str(FILE), "--tracks", "belgian-pave/thesis", "--seconds", "10"]
    words += ["--sweep", "speed=8:12:12", "--out", str(table)]
    command = [sys.executable, "-m", "wheelhop.cli.main", *words]
    killed = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        wait_until(lambda: journal.exists() and journal.read_bytes().count(b"\n") > 2)
        assert killed.poll() is None
    finally:
        os.kill(killed.pid, signal.SIGKILL)
        killed.wait()
    assert not table.exists()
    finished = [json.loads(line) for line in journal.read_text().split("\n")[:-1]][1:]
    assert 1 < len(finished) < 12
    again = sweep("speed=8:12:12")
    again = type(again)(VEHICLE, ("belgian-pave/thesis",), (), (), again.axes, 10.0, 0)
    computed, rows = run_sweep(again, table, ThreadPoolExecutor(2))
    assert computed == 12 - len(finished)
    for line in finished:
        assert rows[line["point"]] == line["rows"][0]
    assert not journal.exists()


SLOW = """
import sys, time
from pathlib import Path
from wheelhop.predict.journal import run_sweep
from wheelhop.predict.workers import workers


class Slow:
    things, fingerprint = "points", "slow"

    def __len__(self):
        return 5

    def name(self, number):
        return str(number)

    def files(self, number):
        return ""

    def rows(self, number):
        print("begun", flush=True)
        time.sleep(10 * {PATIENCE_S})


if __name__ == "__main__":
    try:
        with workers(2) as executor:
            print("starting", flush=True)
            run_sweep(Slow(), Path("t.parquet"), executor)
    except KeyboardInterrupt:
        sys.exit(130)
"""


@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize("word", ["starting", "begun"])
def test_an_interruption_ends_workers_at_once_and_they_say_nothing(word, tmp_path):
    """A terminal sends it to all of them, which may just be starting."""
    (tmp_path / "slow.py").write_text(SLOW.replace("{PATIENCE_S}", str(PATIENCE_S)))
    with subprocess.Popen(
        [sys.executable, "slow.py"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    ) as process:
        while process.stdout.readline() != f"{word}\n":
            pass
        time.sleep(0.5)
        os.killpg(process.pid, signal.SIGINT)
        try:
            _, err = process.communicate(timeout=PATIENCE_S)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    assert (process.returncode, err) == (130, "")
