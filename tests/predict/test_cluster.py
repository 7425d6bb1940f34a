"""A sweep on a Dask cluster, a worker of which is killed."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from threading import Thread

import pyarrow.parquet as pq
import pytest

from tests.patience import PATIENCE_S, wait_until
from tests.predict.test_sweep import FILE, sweep
from wheelhop.cli.main import main
from wheelhop.predict.journal import run_sweep

distributed = pytest.importorskip("distributed")
WORDS = ["simulate", str(FILE), "--tracks", "washboard/low", "--speed", "9", "--seconds", "2"]


@pytest.fixture
def scheduler():
    with distributed.LocalCluster(n_workers=0, dashboard_address=None) as made:
        yield made.scheduler_address


def worker(address):
    command = [sys.executable, "-m", "distributed.cli.dask_worker", address, "--no-nanny"]
    command += ["--nthreads", "1", "--no-dashboard"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


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
    monkeypatch.setattr("wheelhop.predict.workers.ANSWERS_S", 0.3)
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
