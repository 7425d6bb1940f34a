"""Where a law is missing and which: python -m benchmarks.law_places [NAME…] [--seed N] [--screen]

Laws that are in nobody's library, hidden in the cars of the independent simulator, 8 runs each, and
clean cars. Printed for each: what the model without the law leaves over the noise, the place that
`wheelhop law` names, the simplest law that does as well as any, its held-out error over the noise,
and how far its force is from the true one along the true motion of the held-out runs, r.m.s.: over
the whole force of the strut, tyre or seat, and, less what any spring and damper are, over that of
the missing law. With --screen only the places, as regression ranks them, and its time.
"""

from __future__ import annotations

import argparse
import tempfile
import time
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.vehicles import Car, car_of
from tests.truth import PRESETS, Truth, integrate, read_truth, write_campaign
from tests.truth import outside_effects as outside
from tests.truth import outside_laws as special
from tests.truth.effect import Effect
from tests.truth.model import STEP_S, Motion
from tests.truth.vehicle import axle, corner_positions
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import fit_baseline
from wheelhop.diagnose.confirm.in_full import least_gain
from wheelhop.effects import load_effects
from wheelhop.law import Found, Moved, find_law
from wheelhop.law.along import force_along
from wheelhop.law.places import Where
from wheelhop.law.search import screened, seat_for
from wheelhop.vehicle import read_vehicle

Array = NDArray[np.floating]
PRESET, NOISE_M_S2 = "atv", 0.1
CLEAN = 2


def _hidden(car: Car) -> dict[str, tuple[str, Callable[[], Effect]]]:
    """The place each law is at, and the law, plainly visible on this car."""
    travel, rate = float(car.travel_m.max()), float(car.rate_m_s.max())
    load = float(car.static_load_N.mean())
    return {
        "fading-damper": ("all struts", lambda: outside.DamperFade(0.25)),
        "one-sided-play": (
            "all struts",
            lambda: special.OneSidedPlay(0.3 * travel, 0.15 * travel),
        ),
        "bump-rubber": ("all struts", lambda: special.BumpRubber(0.4 * travel, 0.15 * load)),
        "cracked-weld": ("front left strut", lambda: special.CrackedWeld(1.0, 0.4)),
        "blow-off-valve": (
            "all struts",
            lambda: special.BlowOffValve(0.35 * rate, 0.2 * rate, 0.7),
        ),
        "stick-slip-seat": (
            "driver's seat",
            lambda: special.StickSlipSeat(70.0, 3.5, 0.2, -0.1, 0.0, 60.0),
        ),
        "load-friction": ("all struts", lambda: special.LoadFriction(0.04, 0.04)),
        "tyre-hysteresis": ("all tyres", lambda: outside.TyreHysteresis(0.15, 0.6)),
        "orifice-damping": ("all struts", lambda: outside.OrificeDamping(0.3, rate)),
        "bypass-damping": ("all struts", lambda: outside.BypassDamping(0.6, travel)),
        "bouc-wen-spring": ("all struts", lambda: outside.BoucWenSpring(0.1 * load, 0.2 * travel)),
    }


def true_force(truth: Truth, where: Where, before_s: float) -> tuple[Moved, Array, Array]:
    """The motion of a place's first part in the held-out runs, its force, and that of its spring
    and damper, every millisecond."""
    of_place = _seat if where.kind == "mount" else _strut_or_tyre
    every = round(1e-3 / STEP_S)
    parts = []
    for name, run in truth.runs.items():
        if truth.roles[name] == "validate":
            motion = integrate(truth.vehicle, run, truth.effects, step_s=STEP_S)
            # Forces are those of the middle of each step.
            begun = motion.time[1:] > 0.0
            parts.append([way[begun][::every] for way in of_place(truth, where, motion)])
    x, v, force, line = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Moved(x, v, tuple(len(part[0]) for part in parts), before_s=before_s), force, line


def _strut_or_tyre(truth: Truth, where: Where, motion: Motion) -> tuple[Array, ...]:
    """Extension, rate, force and that of spring and damper at the middle of every step."""
    corner, strut = where.corners[0], where.kind == "strut"
    body, wheel = motion.position[:, corner], motion.position[:, 4 + corner]
    x = body - wheel if strut else wheel - motion.road[:, corner]
    middle, v = 0.5 * (x[1:] + x[:-1]), np.diff(x) / STEP_S
    force = motion.suspension_force if strut else motion.tyre_force
    part, end = ("suspension", "") if strut else ("wheel", "tyre_")
    key = f"{part}.{axle(corner)}.{end}"
    spring, damper = (truth.vehicle[f"{key}{n}"] for n in ("stiffness_N_m", "damping_N_s_m"))
    return middle, v, -force[:, corner], spring * middle + damper * v


def _seat(truth: Truth, where: Where, motion: Motion) -> tuple[Array, ...]:
    """The same of the driver's seat, whose force is what moves the driver."""
    (seat,) = truth.effects
    assert isinstance(seat, special.StickSlipSeat)
    corners = np.array([(1.0, x, y) for x, y in corner_positions(truth.vehicle)])
    at_seat = np.array([1.0, seat.x_m, seat.y_m]) @ np.linalg.pinv(corners)
    x, rate = motion.joints["seat"]
    driver = motion.velocity[:, :4] @ at_seat + rate
    middle, v = 0.5 * (x[1:] + x[:-1]), np.diff(x) / STEP_S
    omega = 2.0 * np.pi * seat.freq_hz
    line = seat.mass_kg * (omega**2 * middle + 2.0 * seat.zeta * omega * v)
    return middle, v, -seat.mass_kg * np.diff(driver) / STEP_S, line


def law_errors(found: Found, truth: Truth) -> tuple[float, float]:
    """Error of the preferred law's force over the whole force, and over the missing law's."""
    preferred, where = found.preferred, found.where
    assert preferred is not None and where is not None
    assert found.moved is not None
    moved, whole, line = true_force(truth, where, found.moved.before_s)
    ours = force_along(preferred.rung.model, where, moved, 1e-3)
    columns = [np.ones_like(whole), moved.extension, moved.rate]
    basis = np.linalg.qr(np.stack(columns, axis=1))[0]

    def beyond(force: Array) -> Array:
        return np.asarray(force - basis @ (basis.T @ force))

    off, missing = beyond(ours - whole), beyond(whole - line)
    everything = float(np.std(ours - whole) / np.std(whole))
    return everything, float(np.linalg.norm(off) / max(float(np.linalg.norm(missing)), 1e-9))


def look_for(name: str, place: str, effects: Sequence[Effect], seed: int) -> bool:
    """Make, search, print a line; whether the place was right."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "c"
        preset = PRESETS[PRESET]
        write_campaign(folder, preset, effects, seed=seed, short=True, noise_rms=NOISE_M_S2)
        floor = tomllib.loads((folder / "truth.toml").read_text())["oracle_rel_validate"]
        campaign = read_campaign(folder)
        vehicle = read_vehicle(campaign.vehicle_file)
        begin = time.process_time()
        found = find_law(campaign, vehicle, [], list(load_effects().values()), lambda text: None)
        took = time.process_time() - begin
        said = "nothing" if found.where is None else found.where.name
        line = f"{name:18} {place:18} {said:18} {found.base.error / floor:8.2f}"
        if found.preferred is not None:
            rung, own, law = found.preferred.rung, "", ""
            if said == place:
                truth = read_truth_of(folder, effects)
                own, law = (f"{100 * e:.1f} %" for e in law_errors(found, truth))
            line += f" {rung.error / floor:8.2f} {own:>8} {law:>8}  {found.preferred.name:18}"
        print(f"{line} {took:5.0f} s", flush=True)
        for rival in (found.free, found.formula, *found.named):
            if rival is not None:
                print(
                    f"    {rival.rung.error / floor:6.2f} {rival.name}: {rival.words}", flush=True
                )
        return said == place


def silent(text: str) -> None:
    """No word of progress."""


def screen_for(name: str, place: str, effects: Sequence[Effect], seed: int) -> bool:
    """Make, rank the places, print a line; whether the first is right."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "c"
        preset = PRESETS[PRESET]
        write_campaign(folder, preset, effects, seed=seed, short=True, noise_rms=NOISE_M_S2)
        floor = tomllib.loads((folder / "truth.toml").read_text())["oracle_rel_validate"]
        campaign = read_campaign(folder)
        found = fit_baseline(campaign, read_vehicle(campaign.vehicle_file), progress=silent)
        begin = time.process_time()
        promises, *_ = screened(found.workshop, found.rung, silent)
        ranked = [(p.screened.score, p.where.name, p.screened.error) for p in promises]
        took = time.process_time() - begin
        seat = seat_for(found.workshop, found.rung, list(load_effects().values()))
        if seat is not None:
            ranked.append((seat.score, "driver's seat", seat.error))
        first, second = sorted(ranked, reverse=True)[:2]
        enough = least_gain(found.workshop, found.rung) / 2.0
        said = first[1] if first[0] > enough else "nothing"
        print(
            f"{name:18} {place:18} {said:18} {found.rung.error_fit / floor:8.2f}"
            f" {first[2] / floor:8.2f}   {first[0]:8.0f} {second[0]:8.0f} {second[1]:18}"
            f" {took:5.1f} s",
            flush=True,
        )
        return said == place


def read_truth_of(folder: Path, effects: Sequence[Effect]) -> Truth:
    """The truth of a campaign whose effects have no id to be read back by."""
    file = folder / "truth.toml"
    text = file.read_text()
    names = "effects = [" + ", ".join(f'"{effect.id}"' for effect in effects) + "]"
    file.write_text(text.replace(names, 'effects = ["none"]'))
    truth = read_truth(folder)
    return Truth(truth.vehicle, list(effects), truth.runs, truth.roles, truth.recorded)


def main() -> None:
    """Print the table and how many places were right."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="of the laws; all, and clean cars, by default")
    parser.add_argument("--seed", type=int, default=20, help="of the first car")
    parser.add_argument("--screen", action="store_true", help="rank places only")
    chosen = parser.parse_args()
    look = screen_for if chosen.screen else look_for
    columns = "   evidence  of the next" if chosen.screen else f" {'whole':>8} {'missing':>8}  law"
    print(f"{'law':18} {'place':18} {'named':18} {'without':>8} {'with':>8}{columns}")
    right, asked = 0, 0
    seeds = chosen.seed
    for number, name in enumerate(_hidden(car_of(PRESETS[PRESET], seeds))):
        if not chosen.names or name in chosen.names:
            seed = seeds + number
            place, make = _hidden(car_of(PRESETS[PRESET], seed))[name]
            right += look(name, place, [make()], seed)
            asked += 1
    for seed in range(seeds + 100, seeds + 100 + CLEAN):
        if not chosen.names or "clean" in chosen.names:
            look("clean", "nothing", [], seed)
    if asked:
        print(f"right place: {right} of {asked}")


if __name__ == "__main__":
    main()
