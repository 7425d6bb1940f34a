"""A sweep on a Dask cluster: who may work on it, and what happens when some of it is lost."""

import json
import os
import pickle
import re
import shutil
import signal
import socket
import subprocess
import sys
from concurrent.futures import Future, ThreadPoolExecutor
from importlib import import_module
from pathlib import Path
from threading import Thread

import pyarrow.parquet as pq
import pytest

from tests.patience import PATIENCE_S, wait_until
from tests.predict.test_sweep import FILE, sweep
from wheelhop.campaign import CampaignError
from wheelhop.cli.main import main
from wheelhop.predict import cluster as cluster_module
from wheelhop.predict.cluster import cluster, compute
from wheelhop.predict.identity import identity
from wheelhop.predict.journal import run_sweep

distributed = pytest.importorskip("distributed")
WORDS = ["simulate", str(FILE), "--tracks", "washboard/low", "--speed", "9", "--seconds", "2"]


@pytest.fixture(autouse=True)
def compiled(monkeypatch):
    """That the integrator is compiled first is no news here, whichever test comes first."""
    monkeypatch.setattr("wheelhop.cli.progress.COMPILED", ())


@pytest.fixture
def scheduler():
    with distributed.LocalCluster(n_workers=0, dashboard_address=None) as made:
        yield made.scheduler_address


def worker(address, before="", **environment):
    """A worker in a process of its own, with a line of Python `before` it begins."""
    code = f"{before}\nfrom distributed.cli.dask_worker import main; main()"
    command = [sys.executable, "-c", code, address, "--no-nanny", "--nthreads", "1"]
    return subprocess.Popen(
        [*command, "--no-dashboard"],
        env={**os.environ, **environment},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def until_there(scheduler, count):
    with distributed.Client(scheduler, set_as_default=False) as client:
        client.wait_for_workers(count, timeout=300)
        return list(client.nthreads())


def swept(scheduler, tmp_path):
    words = [*WORDS, "--sweep", "body.mass_kg=200:240:8", "--out", str(tmp_path / "t.parquet")]
    return main([*words, "--cluster", scheduler])


@pytest.mark.slow
def test_a_killed_worker_changes_nothing_in_the_table(tmp_path, scheduler):
    axis = "body.mass_kg=200:240:60"
    table, journal = tmp_path / "t.parquet", tmp_path / "t.parquet.journal"
    both = [worker(scheduler), worker(scheduler)]
    try:
        with distributed.Client(scheduler) as client:
            client.wait_for_workers(2, timeout=PATIENCE_S)

        def kill_one():
            wait_until(lambda: journal.exists() and journal.read_bytes().count(b"\n") > 5)
            os.kill(both[0].pid, signal.SIGKILL)

        killer = Thread(target=kill_one)
        killer.start()
        words = [*WORDS, "--sweep", axis, "--out", str(table), "--cluster", scheduler]
        assert main(words) == 0
        killer.join()
        assert both[0].wait(timeout=PATIENCE_S) == -signal.SIGKILL
        assert both[1].poll() is None
    finally:
        for process in both:
            process.kill()
            process.wait()
    _, alone = run_sweep(sweep(axis), tmp_path / "alone.parquet", ThreadPoolExecutor(1))
    assert pq.read_table(table).to_pylist() == alone
    assert not journal.exists()


def test_where_nobody_answers_is_a_line(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(import_module("wheelhop.predict.cluster"), "ANSWERS_S", 0.3)
    out = ["--out", str(tmp_path / "t.parquet")]
    for words, said in (
        (["--cluster", "tcp://127.0.0.1:9"], "no Dask scheduler answers"),
        (["--cluster", "nowhere:at:all"], "no Dask scheduler answers"),
        (["--cluster", "tcp://127.0.0.1:9", "--jobs", "2"], "leave one of the two out"),
    ):
        assert main([*WORDS, "--sweep", "speed=8:10:2", *out, *words]) == 2
        error = capsys.readouterr().err
        assert said in error and error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_cluster_without_workers_is_a_line(tmp_path, capsys, scheduler):
    words = [*WORDS, "--sweep", "speed=8:10:2", "--out", str(tmp_path / "t.parquet")]
    assert main([*words, "--cluster", scheduler]) == 2
    assert "has no workers" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_worker_of_another_version_gets_no_work(tmp_path, capsys, scheduler):
    """The same number of version, and one other line of text."""
    for portion in sys.modules["wheelhop"].__path__:
        shutil.copytree(portion, tmp_path / "old/wheelhop", dirs_exist_ok=True)
    ride = tmp_path / "old/wheelhop/predict/ride.py"
    ride.write_text(f"{ride.read_text()}\nWRONG_BY_A_FACTOR = 2.0\n")
    both = [worker(scheduler), worker(scheduler, PYTHONPATH=str(tmp_path / "old"))]
    try:
        until_there(scheduler, 2)
        assert swept(scheduler, tmp_path) == 2
    finally:
        for process in both:
            process.kill()
            process.wait()
    (line,) = capsys.readouterr().err.splitlines()
    found = re.findall(r"worker (tcp://[\d.:]+) has wheelhop (\S+ \(\w+\))", line)
    assert len(found) == 1 and found[0][1] != identity() and identity() in line
    assert not (tmp_path / "t.parquet").exists()


def test_a_worker_without_wheelhop_is_named(tmp_path, capsys, scheduler):
    bare = worker(scheduler, "import sys; sys.modules['wheelhop'] = None")
    try:
        (address,) = until_there(scheduler, 1)
        assert swept(scheduler, tmp_path) == 2
    finally:
        bare.kill()
        bare.wait()
    (line,) = capsys.readouterr().err.splitlines()
    assert f"worker {address} has no such wheelhop" in line


def test_a_worker_that_came_later_says_who_it_is_before_it_unpacks_its_work(scheduler):
    with (
        distributed.LocalCluster(n_workers=1, processes=False, dashboard_address=None) as made,
        distributed.Client(made, set_as_default=False) as client,
    ):
        assert client.submit(compute, identity(), pickle.dumps((abs, (-2,), {}))).result() == 2
        with pytest.raises(CampaignError, match=r"worker inproc://.* has wheelhop .*1\.0 \(abc\)"):
            client.submit(compute, "1.0 (abc)", b"no pickle at all").result()


class Scripted:
    """A client of a scheduler whose workers at each look are told; nothing is ever computed."""

    def __init__(self, *looks):
        self.looks, self.futures = list(looks), []

    def nthreads(self):
        return dict.fromkeys(self.looks.pop(0) if len(self.looks) > 1 else self.looks[0], 1)

    def run(self, function, workers, on_error):
        return {name: "1.0 (abc)" if "old" in name else function() for name in workers}

    def get_executor(self, pure):
        return self

    def submit(self, function, *work):
        self.futures.append(Future())
        return self.futures[-1]

    def shutdown(self, wait):
        for future in self.futures:
            if future.cancel():
                future.set_running_or_notify_cancel()

    def __enter__(self):
        return self

    def __exit__(self, *raised):
        self.shutdown(False)


@pytest.mark.parametrize(
    ("looks", "why"),
    [
        ([["a"], ["a"], []], "no worker is left"),
        ([["a"], ["a", "old"]], r"worker old has wheelhop 1\.0 \(abc\)"),
    ],
)
def test_who_works_is_looked_at_all_the_time(looks, why, tmp_path, monkeypatch):
    monkeypatch.setattr(cluster_module, "LOOKS_S", 0.0)
    monkeypatch.setattr(cluster_module, "_connected", lambda address, place: Scripted(*looks))
    told = []
    with pytest.raises(CampaignError, match=why), cluster("tcp://x:1", told.append) as workers:
        run_sweep(sweep("speed=8:10:2"), tmp_path / "t.parquet", workers)
    assert bool(told) == ("left" in why)


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


@pytest.mark.parametrize("lost", ["worker", "scheduler"])
def test_what_is_lost_is_a_line_and_what_is_finished_stays(lost, tmp_path, capfd, monkeypatch):
    monkeypatch.setattr(cluster_module, "LOOKS_S", 0.05)
    monkeypatch.setattr(cluster_module, "WAITS_LOOKS", 2)
    address = f"tcp://127.0.0.1:{(port := free_port())}"
    code = "from distributed.cli.dask_scheduler import main; main()"
    where = ["--host", "127.0.0.1", "--port", str(port), "--no-dashboard"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = subprocess.Popen([sys.executable, "-c", code, *where], **quiet)
    only = worker(address)
    one, table = sweep("body.mass_kg=200:240:40"), tmp_path / "t.parquet"

    def kill(text):
        (only if lost == "worker" else scheduler).kill()

    try:
        with distributed.Client(address, timeout=300, set_as_default=False) as client:
            client.wait_for_workers(1, timeout=300)
        why = "no worker is left" if lost == "worker" else "the scheduler has ended"
        with (
            pytest.raises(CampaignError, match=f"{why}.*goes on from here"),
            cluster(address) as at,
        ):
            run_sweep(one, table, at, kill)
    finally:
        for process in (only, scheduler):
            process.kill()
            process.wait()
    assert capfd.readouterr().err == ""
    lines = [json.loads(line) for line in Path(f"{table}.journal").read_text().splitlines()]
    computed, rows = run_sweep(one, table, ThreadPoolExecutor(1))
    assert computed == 40 - len(lines[1:]) < 40
    for line in lines[1:]:
        assert rows[line["point"]] == line["rows"][0]


@pytest.mark.parametrize("address", ["nonsense", "tcp://", "smoke://127.0.0.1:9", ""])
def test_an_address_that_is_none_is_a_line_to_the_very_end(address, tmp_path):
    """What is only half made complains when the interpreter ends."""
    words = [*WORDS, "--sweep", "speed=8:10:2", "--out", str(tmp_path / "t.parquet")]
    command = [sys.executable, "-m", "wheelhop.cli.main", *words, "--cluster", address]
    done = subprocess.run(command, capture_output=True, text=True)
    lines = [line for line in done.stderr.splitlines() if not line.startswith("compiling")]
    assert done.returncode == 2 and len(lines) == 1 and "write it as tcp://HOST:PORT" in lines[0]
