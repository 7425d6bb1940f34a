"""Ask the program, as a user does: a process of its own for every campaign, no truth in sight."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from benchmarks.blind.plan import Case
from benchmarks.blind.work import Work, write_json

ROOT = Path(__file__).parents[2]
LONGEST_S = 900.0


def ask(case: Case, work: Work, threads: int, budget: str | None = None) -> dict[str, Any]:
    """Diagnose the case's campaign, with a `--budget` if one is given; returns how the program
    ended and how long it took."""
    answer = work.diagnosis(case.name)
    answer.parent.mkdir(parents=True, exist_ok=True)
    answer.unlink(missing_ok=True)
    program = ["wheelhop.cli.main"]
    if case.kind == "without":
        program = ["benchmarks.blind.without", case.hidden[0]]
    command = [sys.executable, "-m", *program, "diagnose", str(work.campaign(case.campaign))]
    command += ["--json", str(answer), "--jobs", str(threads)]
    command += ["--budget", budget] if budget else []
    begin, spent = time.perf_counter(), _spent_by_children()
    try:
        done = subprocess.run(
            command,
            cwd=ROOT,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
            capture_output=True,
            text=True,
            timeout=LONGEST_S,
        )
        status, complaint = done.returncode, done.stderr.strip()[-1000:]
    except subprocess.TimeoutExpired:
        status, complaint = -1, f"stopped after {LONGEST_S:.0f} s"
    ended = {
        "status": status,
        "seconds": round(time.perf_counter() - begin, 2),
        "cpu_seconds": round(_spent_by_children() - spent, 2),
        "complaint": complaint if status else "",
    }
    write_json(work.timing(case.name), ended)
    return ended


def _spent_by_children() -> float:
    """Processor seconds of the programs this process has run."""
    times = os.times()
    return times.children_user + times.children_system
