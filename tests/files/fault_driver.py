"""Run one command of wheelhop again and again on a disk that fails at another place each time.

Started with faults.c preloaded: `python fault_driver.py SCENARIO FOLDER`. Each attempt is a forked
child, so that nothing it leaves in memory helps the next one. Prints how many places were tried.
"""

import contextlib
import ctypes
import gc
import os
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from tests.campaign.build import write_campaign
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.cli.main import main
from wheelhop.files import is_draft
from wheelhop.formats import ExchangeError, read, write
from wheelhop.logger.recording import Channel, Recording

OFF, ONCE, FOREVER, CUT = range(4)
NAMES = {ONCE: "once", FOREVER: "forever", CUT: "cut"}
POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
WASHBOARD = ("--track", "washboard", "amplitude_mm=15", "pitch_mm=400", "--speed-kmph", "7.5")
ENDED_BY_A_CUT = 137

disk = ctypes.CDLL(None)


@dataclass(frozen=True)
class Scenario:
    """`prepare` fills a folder, `command` is what is run in it; `whole`: its files belong together,
    and are all of before or all of after; else that holds of each of them alone."""

    prepare: Callable[[Path], object]
    command: Callable[[Path], list[str]]
    whole: bool = True


def recording_in(folder: Path, suffix: str = ".csv", seed: int = 1, unit: str = "m/s²") -> Path:
    file = folder / f"source{suffix}"
    write(recording_of(seed, unit), file)
    return file


def recording_of(seed: int, unit: str = "m/s²") -> Recording:
    values = np.random.default_rng(seed).normal(0, 3, (600, 8)).round(3)
    return Recording(values, 100.0, tuple(Channel(p, unit) for p in POINTS))


def two_recordings(folder: Path) -> None:
    recording_in(folder)
    recording_in(folder, ".uff", 2, "code")


def fitted(folder: Path) -> None:
    """A campaign whose fit is known already: what is tested is how it is written down."""
    import wheelhop.cli.compare as compare_command
    from wheelhop.api import compare, verbs
    from wheelhop.report import reports
    from wheelhop.report.page import write_page

    write_campaign(folder)
    result = compare(folder)
    result.to_json()
    pages: list[tuple[str, list[str]]] = []
    reports.write_page = lambda path, name, body: pages.append((name, list(body)))
    result.write_report(folder / "page")
    name, body = pages[0]
    reports.write_comparison_report = lambda path, *rest: write_page(path, name, body)
    compare_command.compare = lambda *words, **options: result
    verbs.fit_baseline = lambda *rest, **options: SimpleNamespace(workshop=result.workshop)
    verbs.fit_with = lambda *rest: [None]
    verbs.steps_of = lambda *rest: [result.last]


def fitted_before(folder: Path) -> None:
    fitted(folder)
    for name in ("x.json", "x.html", "model.toml"):
        (folder / name).write_text("of before\n")


def begun(folder: Path) -> None:
    source = recording_in(folder)
    assert main(["campaign", "new", str(folder / "c"), str(source)]) == 0
    added = ["campaign", "add", str(folder / "c"), str(source), "--id", "first", *WASHBOARD]
    assert main(added) == 0


def logged(folder: Path) -> None:
    from tests.logger.session import random_sums, session

    (folder / "card.img").write_bytes(session(random_sums()))


def plain_picture(self: object, file: Path, **rest: object) -> None:
    """Drawing takes half a second, and is not what is tested."""
    with file.open("wb") as out:
        out.write(b"a picture" * 999)


def drawn(folder: Path) -> None:
    from matplotlib.figure import Figure

    Figure.savefig = plain_picture


def thesis_drawn(folder: Path) -> None:
    from matplotlib.figure import Figure

    import wheelhop.cli.thesis as thesis_command
    import wheelhop.report.thesis as page
    from wheelhop.files import write_picture
    from wheelhop.report import transfer_figures as figures

    drawn(folder)
    thesis_command.thesis_rows = list
    figures.racing_car = lambda: None
    figures.study = figures.stiffened = lambda *rest: dict.fromkeys(("front", "rear"))
    figures.draw_study = lambda variants, varied, path: write_picture(path, Figure())
    page.FIGURES = {number: (Figure, caption) for number, (_, caption) in page.FIGURES.items()}


def framed(folder: Path) -> None:
    drawn(folder)
    shutil.copy("examples/frame/baja.toml", folder)


def measured_on_a_rig(folder: Path) -> None:
    drawn(folder)
    shutil.copytree("examples/rig", folder, dirs_exist_ok=True)
    shutil.copy("examples/clean/vehicle.toml", folder)


def surveyed(folder: Path) -> None:
    x = np.arange(0, 20, 0.1)
    rows = np.column_stack([x, np.sin(x), np.cos(x)])
    np.savetxt(folder / "survey.csv", rows, "%.6g", ",", header="x_m,left_m,right_m", comments="")


def simulated(folder: Path) -> None:
    """Each drive is known already, as is what its vehicle does: the folder is what is tested."""
    import wheelhop.cli.simulate as simulate_command
    from wheelhop.predict import make

    surveyed(folder)
    shutil.copy("examples/clean/vehicle.toml", folder)
    made = recording_of(3)
    make.recording = lambda *rest: made
    simulate_command.print_rides = lambda *rest: [SimpleNamespace(tyre_load_least=1.0)]


def calibrated(folder: Path) -> None:
    from tests.calibration.test_calibrate_command import SENSORS
    from wheelhop.hil_sim.rig_flip import flip_log

    drawn(folder)
    write(flip_log(SENSORS, np.random.default_rng(1), rest_s=20.0), folder / "flip.csv")


def outputs(folder: Path) -> list[str]:
    return ["--json", f"{folder}/x.json", "--figure", f"{folder}/x.png"]


def survey(folder: Path) -> list[str]:
    return [f"profile:file={folder}/survey.csv"]


SCENARIOS = {
    "campaign-new": Scenario(
        recording_in,
        lambda f: ["campaign", "new", f"{f}/deep/c", f"{f}/source.csv", "--title", "t"],
    ),
    "campaign-add": Scenario(
        begun,
        lambda f: [
            *("campaign", "add", f"{f}/c", f"{f}/source.csv", "--from", "1", "--id", "next"),
            *WASHBOARD,
        ],
    ),
    **{
        f"convert-{suffix}": Scenario(
            recording_in,
            lambda f, suffix=suffix: ["convert", f"{f}/source.csv", f"{f}/new.{suffix}"],
        )
        for suffix in ("csv", "parquet", "uff")
    },
    "convert-force": Scenario(
        two_recordings,
        lambda f: ["convert", f"{f}/source.uff", f"{f}/source.csv", "--force"],
    ),
    "import": Scenario(
        recording_in,
        lambda f: ["import", f"{f}/source.csv", "--out", f"{f}/imported"],
    ),
    "compare": Scenario(
        fitted_before,
        lambda f: ["compare", str(f), "--json", f"{f}/x.json", "--report", f"{f}/x.html"],
        whole=False,
    ),
    "add": Scenario(fitted_before, lambda f: ["add", str(f), "dry-friction"]),
    "recover": Scenario(logged, lambda f: ["recover", f"{f}/card.img", "--into", f"{f}/saved"]),
    "decode": Scenario(logged, lambda f: ["decode", f"{f}/card.img", "--out", f"{f}/run.csv"]),
    "health": Scenario(
        lambda f: (drawn(f), recording_in(f)),
        lambda f: ["health", f"{f}/source.csv", *outputs(f)],
        whole=False,
    ),
    "frame": Scenario(framed, lambda f: ["frame", f"{f}/baja.toml", *outputs(f)], whole=False),
    "rates": Scenario(
        measured_on_a_rig,
        lambda f: [
            *("rates", f"{f}/front-strut.csv", f"{f}/front-damper.csv"),
            *("--motion-ratio", "0.7", "--axle", "front", "--into", f"{f}/vehicle.toml"),
            *outputs(f),
        ],
        whole=False,
    ),
    "thesis": Scenario(
        thesis_drawn, lambda f: ["thesis", "--figures", f"{f}/figures"], whole=False
    ),
    "new": Scenario(
        lambda f: None,
        lambda f: [
            *("new", f"{f}/deep/car", "--front-kg", "150", "--rear-kg", "180"),
            *("--wheelbase-m", "1.5", "--track-width-m", "1.2"),
        ],
    ),
    "road-csv": Scenario(surveyed, lambda f: ["road", *survey(f), "--out", f"{f}/road.csv"]),
    "road-crg": Scenario(surveyed, lambda f: ["road", *survey(f), "--out", f"{f}/road.crg"]),
    "simulate-campaign": Scenario(
        simulated,
        lambda f: [
            *("simulate", f"{f}/vehicle.toml", "--tracks", *survey(f), "--speed", "10", "20"),
            *("--out", f"{f}/deep/c"),
        ],
    ),
    "calibrate": Scenario(
        calibrated,
        lambda f: [*("calibrate", "--flip", f"{f}/flip.csv", "--out", f"{f}/calibration.toml")],
        whole=False,
    ),
}

State = dict[str, bytes | None]
REFUSED = b"refused"


def state(folder: Path, drafts: bool = True) -> State:
    """Every file with its bytes, every folder; drafts that a power cut has left if wanted."""
    return {
        str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None
        for path in sorted(folder.rglob("*"))
        if drafts or not any(is_draft(Path(part)) for part in path.relative_to(folder).parts)
    }


def meaning(path: Path, data: bytes | None) -> bytes | None:
    """Of samples with a header beside them what the two say together, or that reading refuses them
    as not belonging together; of any other file its bytes."""
    if not path.with_name(f"{path.name}.toml").is_file():
        return data
    try:
        found = read(path)
    except ExchangeError as error:
        assert "is the header of other samples" in str(error), error
        return REFUSED
    return repr((found.channels, found.rate_hz, found.values.tolist())).encode()


def as_read(folder: Path) -> State:
    """What the files mean: of a campaign those that campaign.toml names, else all."""
    if not (folder / "c").is_dir():
        return {
            name: meaning(folder / name, data)
            for name, data in state(folder, drafts=False).items()
            # A header without samples says nothing, a campaign begins with campaign.toml.
            if not (name.endswith(".toml") and name[:-5].endswith((".csv", ".uff")))
            and not (name.startswith("deep") and not (folder / "deep/c/campaign.toml").exists())
            and not (data is None and name in ("saved", "imported"))
        }
    try:
        campaign = read_campaign(folder / "c")
    except CampaignError as error:
        return {"error": str(error).encode()}
    return {"toml": (folder / "c/campaign.toml").read_bytes()} | {
        run.id: run.file.read_bytes() for run in campaign.runs
    }


def attempt(words: list[str], mode: int, place: int, said: Path) -> tuple[int, str, list[str]]:
    """Exit status, what was said on stderr, and, if it came to its end, how many calls changed the
    disk and which modules it has loaded."""
    counted, count = os.pipe()
    child = os.fork()
    if child == 0:
        out = os.open(said, os.O_CREAT | os.O_TRUNC | os.O_WRONLY)
        os.dup2(out, 2)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        status = 1
        try:
            disk.fault_arm(mode, ctypes.c_long(place))
            status = main(words)
            disk.fault_calls.restype = ctypes.c_long
            os.write(count, " ".join([str(disk.fault_calls()), *sys.modules]).encode())
        except BaseException:
            import traceback

            traceback.print_exc()
        finally:
            sys.stderr.flush()
            os._exit(status)
    os.close(count)
    with os.fdopen(counted) as file:
        told = file.read().split()
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), said.read_text(), told


def run(scenario: Scenario, top: Path) -> int:
    """Fail every call in turn in every way; return how many attempts that were."""
    folder, kept, said = top / "disk", top / "kept", top / "said"
    folder.mkdir()
    scenario.prepare(folder)
    shutil.copytree(folder, kept)
    words = scenario.command(folder)
    before, before_read = state(folder), as_read(folder)
    status, error, (count, *modules) = attempt(words, OFF, 0, said)
    assert status == 0, error
    for module in modules:  # here, and not in every child
        with contextlib.suppress(Exception):
            import_module(module)
    gc.freeze()  # a child that looks for garbage would copy all that it shares with its parent
    calls = int(count)
    after, after_read = state(folder), as_read(folder)
    assert after != before and calls > 3, calls
    tried = 0
    for mode, name in NAMES.items():
        for place in range(calls):
            where = f"call {place} of {calls} fails {name}"
            shutil.rmtree(folder)
            shutil.copytree(kept, folder)
            status, error, _ = attempt(words, mode, place, said)
            check_status(mode, status, error, where)
            now = state(folder, drafts=mode == ONCE)
            if not scenario.whole:
                for file in {**before, **now}:
                    assert now.get(file) in (before.get(file), after.get(file)), (where, file)
            elif mode == ONCE:
                assert now in (before, after), (where, sorted(now), error)
                assert status or now == after, where
            else:
                now_read = as_read(folder)
                refused = {name: REFUSED for name in now_read if now_read[name] == REFUSED}
                known = (before_read | refused, after_read | refused)
                assert now_read in known, (where, sorted(now))
            if mode == CUT and now != after:  # and then the disk works again
                status, error, _ = attempt(words, OFF, 0, said)
                assert status == 0 or as_read(folder) == after_read, (where, error)
                assert state(folder, drafts=False) == after, (where, error)
            tried += 1
    return tried


def check_status(mode: int, status: int, error: str, where: str) -> None:
    """A power cut says nothing; all else says what is wrong in a line, or does not matter."""
    if mode == CUT:
        assert status == ENDED_BY_A_CUT, (where, status, error)
    else:
        assert (status, error) == (0, "") or (
            status == 2 and error.startswith("wheelhop: ") and error.count("\n") == 1
        ), (where, status, error)


if __name__ == "__main__":
    print(run(SCENARIOS[sys.argv[1]], Path(sys.argv[2])))
