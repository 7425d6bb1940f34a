"""How long wheelhop takes, each figure in a process of its own: python -m benchmarks.timing

Commands are timed from their start to their end, as a user waits for them, the median of three. The
compiled code is cached except for the last figure, which starts with an empty cache.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

ROOT = Path(__file__).parents[1]
CAMPAIGNS = ("clean", "open-dry-friction", "open-driver-seat", "open-speed-fluctuation")

IMPORT = "import wheelhop.diagnose, wheelhop.effects"
READ = """
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import diagnose, fit_baseline
from wheelhop.diagnose.screen.first_order import screen
from wheelhop.effects import load_effects
from wheelhop.vehicle import read_vehicle
campaign = read_campaign({folder!r})
vehicle, effects = read_vehicle(campaign.vehicle_file), load_effects()
def silent(text): pass
"""
BASELINE = READ + "base = fit_baseline(campaign, vehicle, progress=silent)"
SCREEN = "found = screen(base.workshop, base.rung.fit, list(effects.values()))"
DIAGNOSE = READ + "print(diagnose(campaign, vehicle, effects).verdict)"

REPORT = """
import json, resource, sys, time
code, after = json.loads(sys.stdin.read())
scope = {"__name__": "benchmark"}
exec(code, scope)
begin, begin_cpu = time.perf_counter(), time.process_time()
exec(after, scope)
used = resource.getrusage(resource.RUSAGE_SELF)
json.dump([time.perf_counter() - begin, time.process_time() - begin_cpu, used.ru_maxrss / 1024],
          sys.stderr)
"""


def measure(before: str, timed: str, cache: str | None = None) -> tuple[float, float, float]:
    """Wall-clock and processor seconds of `timed`, and the process's peak memory, MB, in a new
    process that has run `before`; with the folder of numba's cache, if another is wanted."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    environment["PYTHONPATH"] = os.pathsep.join(
        [str(ROOT / "host"), *filter(None, [os.environ.get("PYTHONPATH")])]
    )
    if cache is not None:
        environment["NUMBA_CACHE_DIR"] = cache
    done = subprocess.run(
        [sys.executable, "-c", REPORT],
        input=json.dumps([before, timed]),
        env=environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    if done.returncode != 0:
        raise SystemExit(f"{timed.strip().splitlines()[-1]}: {done.stderr.strip()[-2000:]}")
    wall, processor, memory = json.loads(done.stderr.strip().splitlines()[-1])
    return wall, processor, memory


def show(label: str, before: str, timed: str, cache: str | None = None) -> None:
    """Print one line."""
    wall, processor, memory = measure(before, timed, cache)
    print(f"{label:54s} {wall:8.2f} {processor:12.2f} {memory:9.0f}", flush=True)


def wait(*command: str) -> float:
    """Seconds from a command's start to its end."""
    begin = time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "wheelhop.cli.main", *command], cwd=ROOT, stdout=subprocess.DEVNULL
    )
    return time.perf_counter() - begin


def main() -> None:
    """All figures."""
    folder = {name: str(ROOT / "examples" / name) for name in CAMPAIGNS}
    before = READ.format(folder=folder["clean"])
    baseline = BASELINE.format(folder=folder["clean"])
    fitting = baseline.removeprefix(before)
    measure(before, fitting + "\n" + SCREEN)  # fills the cache of compiled code
    print(f"{os.cpu_count()} processors, {time.strftime('%Y-%m-%d %H:%M')}")
    print(f"{'':54s} {'wall, s':>8s} {'processor, s':>12s} {'peak, MB':>9s}")
    for command in (["--help"], ["check", folder["clean"]], ["compare", folder["clean"]]):
        words = " ".join([command[0], *(Path(word).name for word in command[1:])])
        print(f"{f'wheelhop {words}':54s} {median(wait(*command) for _ in range(3)):8.2f}")
    show("import", "", IMPORT)
    show("baseline fit (clean)", before, fitting)
    show("screening of all effects (clean)", baseline, SCREEN)
    for name in CAMPAIGNS:
        show(f"whole diagnosis, import included ({name})", "", DIAGNOSE.format(folder=folder[name]))
    with tempfile.TemporaryDirectory() as empty:
        show("first baseline fit and screening, compiling", "", baseline + "\n" + SCREEN, empty)


if __name__ == "__main__":
    main()
