"""wheelhop beside peers on rigs: python -m benchmarks.rig_peers [CAMPAIGN…]

Of each: E of the runs held out, processor seconds, how many numbers were fitted. Without folders
the rigs are simulated from papers: a positioning drive (A. Janot et al., Data set and reference
models of EMPS, 2019), the Bouc and Wen oscillator (J. P. Noël, M. Schoukens, Hysteretic benchmark
with a dynamic nonlinearity, 2016) and a circuit with a cubic spring (T. Wigren, J. Schoukens,
Three free data sets, ECC 2013), along displacements, noise 0.5 %. Coupled drives show the speed
without its sign, which no component's law does. `nonlinear_benchmarks` fetches its data from the
web when asked; convert them to campaigns and give their folders.

lmfit gets the model that an engineer writes (mass, spring, cubic spring, damper, friction), SciPy
the structure that made the data, PySINDy a library of terms. They come with the extra `peers`.
"""

from __future__ import annotations

import argparse
import tempfile
import time
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import lmfit
import numpy as np
import pysindy
from numpy.typing import NDArray
from scipy import optimize

from wheelhop.api import diagnose
from wheelhop.campaign import ComponentCampaign, RigRun, read_campaign
from wheelhop.compare import InBand
from wheelhop.vehicle import Motion

Array = NDArray[np.float64]
Moved = tuple[Array, Array, Array]
Law = Callable[[Moved, Sequence[float], float], Array]
RATE_HZ, SECONDS, NOISE = 750.0, 6.0, 0.005


def drive(moved: Moved, p: Sequence[float], dt: float) -> Array:
    """m a + c v + F sgn v."""
    _, v, a = moved
    return p[0] * a + p[1] * v + p[2] * np.tanh(v / 1e-3)


def cubic(moved: Moved, p: Sequence[float], dt: float) -> Array:
    """m a + c v + k x + k₃ x³."""
    x, v, a = moved
    return p[0] * a + p[1] * v + p[2] * x + 1e8 * p[3] * x**3


def bouc_wen(moved: Moved, p: Sequence[float], dt: float) -> Array:
    """m a + c v + k x + z, ż = α v − β (γ |v| z + δ v |z|), by Heun's rule."""
    x, v, a = moved
    z = np.zeros(len(x))

    def rate(v: float, z: float) -> float:
        return p[3] * v - p[4] * (abs(v) * z) - p[5] * v * abs(z)

    for t in range(len(x) - 1):
        first = rate(v[t], z[t])
        z[t + 1] = z[t] + 0.5 * dt * (first + rate(v[t + 1], z[t] + dt * first))
    return p[0] * a + p[1] * v + p[2] * x + z


RIGS: dict[str, tuple[Law, tuple[float, ...], float, tuple[float, float]]] = {
    "drive": (drive, (95.1, 203.5, 20.4), 0.05, (0.3, 2.0)),
    "bouc-wen": (bouc_wen, (2.0, 10.0, 5e4, 5e4, 800.0, -1100.0), 7e-4, (5.0, 60.0)),
    "cubic": (cubic, (1.0, 20.0, 2e5, 40.0), 5e-3, (5.0, 60.0)),
}
"""Law, its numbers, r.m.s. of the motion, m, and the band in which it moves, Hz."""


def simulated(name: str, folder: Path) -> Path:
    """A campaign: four runs to fit, two held out, of random waves of four sizes."""
    law, numbers, rms, band = RIGS[name]
    rng, steps = np.random.default_rng([1, *name.encode()]), 8
    time_s = np.arange(round(SECONDS * RATE_HZ) * steps) / (RATE_HZ * steps)
    lines = ['format = 1\nkind = "component"', f'title = "{name}"', 'drive = "displacement"']
    lines += [f"sample_rate_hz = {RATE_HZ}", f"band_hz = [{band[0] / 2}, {2 * band[1]}]"]
    spring = '"none"' if name == "drive" else '"unknown"'
    lines += [f'[component]\nmass_kg = "unknown"\nstiffness_N_m = {spring}']
    lines += ['damping_N_s_m = "unknown"\nrelative_uncertainty = 1.0']
    (folder / "runs").mkdir(parents=True)
    for i, size in enumerate((0.4, 0.7, 1.0, 1.3, 0.5, 1.2)):
        omega = 2.0 * np.pi * rng.uniform(*band, (20, 1))
        phase = rng.uniform(0.0, 2.0 * np.pi, (20, 1))
        scale = size * rms / np.sqrt(10.0)
        x, v, a = (
            scale * (omega**k * np.sin(omega * time_s + phase + k * np.pi / 2)).sum(axis=0)
            for k in range(3)
        )
        force = law((x, v, a), numbers, time_s[1])[::steps]
        force += rng.normal(0.0, NOISE * np.std(force), len(force))
        columns = np.stack([time_s[::steps], x[::steps], force], axis=1)
        np.savetxt(
            folder / "runs" / f"{i}.csv",
            columns,
            delimiter=",",
            header="time_s,displacement_m,force_N",
            comments="",
        )
        role = "fit" if i < 4 else "validate"
        lines += [f'[[run]]\nid = "{i}"\nfile = "runs/{i}.csv"\nrole = "{role}"']
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")
    return folder


class Rig:
    """A campaign as peers see it: motion and force of its runs, E of what they foresee."""

    def __init__(self, campaign: ComponentCampaign) -> None:
        self.campaign, self.dt = campaign, 1.0 / campaign.sample_rate_hz
        runs = [run for run in campaign.runs if isinstance(run, RigRun)]
        if not campaign.drive == "displacement" or len(runs) < len(campaign.runs):
            raise SystemExit(f"{campaign.folder}: peers need an imposed displacement")
        self.runs = [(run, tuple(Motion(campaign, run).at(run.time_s))) for run in runs]

    def residual(self, force: Callable[[Moved], Array], role: str) -> Array:
        """In-band data of what a model leaves."""
        parts = [
            self._band(run).coefficients(run.force - force((moved[0], moved[1], moved[2])))
            for run, moved in self.runs
            if run.role == role
        ]
        return np.nan_to_num(np.concatenate(parts), nan=1e6, posinf=1e6, neginf=-1e6)

    def error(self, force: Callable[[Moved], Array]) -> float:
        """E of the runs held out."""
        left = self.residual(force, "validate")
        whole = self.residual(lambda moved: np.zeros(len(moved[0])), "validate")
        return float(np.linalg.norm(left) / np.linalg.norm(whole))

    def _band(self, run: RigRun) -> InBand:
        return InBand(len(run.time_s), self.campaign.sample_rate_hz, self.campaign.band_hz)


Answer = tuple[float, int]


def by_lmfit(rig: Rig) -> Answer:
    """The model that an engineer writes."""
    names = ("m", "c", "k", "k3", "friction")
    units = [np.ptp(rig.runs[0][0].force) / np.ptp(part) for part in rig.runs[0][1]]
    x_unit, v_unit, a_unit = units
    sizes = (a_unit, v_unit, x_unit, x_unit / np.ptp(rig.runs[0][1][0]) ** 2, 1.0)
    given = lmfit.Parameters()
    for name, size in zip(names, sizes, strict=True):
        given.add(name, value=0.1 * size if name != "k3" else 0.0)

    def force(moved: Moved, p: lmfit.Parameters) -> Array:
        x, v, a = moved
        m, c, k, k3, friction = (p[name].value for name in names)
        return np.asarray(m * a + c * v + k * x + k3 * x**3 + friction * np.tanh(v / 1e-3))

    found = lmfit.minimize(lambda p: rig.residual(lambda moved: force(moved, p), "fit"), given)
    return rig.error(lambda moved: force(moved, found.params)), len(names)


def by_scipy(rig: Rig, law: Law, numbers: Sequence[float]) -> Answer:
    """The structure that made the data, begun 30 % off."""
    size = np.array(numbers)
    start = 1.0 + 0.3 * np.random.default_rng(2).choice([-1.0, 1.0], len(size))

    def left(share: Array) -> Array:
        return rig.residual(lambda moved: law(moved, (share * size).tolist(), rig.dt), "fit")

    found = optimize.least_squares(left, start, x_scale="jac", max_nfev=60)
    best = (found.x * size).tolist()
    return rig.error(lambda moved: law(moved, best, rig.dt)), len(size)


def by_pysindy(rig: Rig) -> Answer:
    """Force as a sparse sum of powers and signs of the motion."""
    units = [float(np.std(part)) for part in rig.runs[0][1]]
    level = float(np.std(rig.runs[0][0].force))
    library = pysindy.ConcatLibrary(
        [
            pysindy.PolynomialLibrary(degree=3, include_bias=True),
            pysindy.CustomLibrary([lambda u: np.tanh(20.0 * u)], [lambda u: f"sgn({u})"]),
        ]
    )

    def scaled(moved: Moved) -> Array:
        return np.stack([part / unit for part, unit in zip(moved, units, strict=True)], axis=1)

    fitted = [(run.force / level, scaled(moved)) for run, moved in rig.runs if run.role == "fit"]
    model = pysindy.SINDy(optimizer=pysindy.STLSQ(threshold=0.01), feature_library=library)
    inputs = [motion for _, motion in fitted]
    forces = [force[:, None] for force, _ in fitted]
    model.fit(inputs, t=rig.dt, x_dot=[np.repeat(f, 3, axis=1) for f in forces])
    terms = int(np.count_nonzero(model.coefficients()[0]))
    return rig.error(lambda moved: level * np.asarray(model.predict(scaled(moved)))[:, 0]), terms


def by_wheelhop(rig: Rig, said: list[str]) -> Answer:
    """The best of its ladder, names before laws; what it is called is `said`."""
    found = diagnose(rig.campaign, jobs=1, progress=False)
    laws = [] if found.law is None else list(found.law.steps)
    best = min([found.steps[-1], *laws], key=lambda s: s.rung.error)
    sure = f"{'+'.join(found.verdict)}, {100 * found.confidence:.0f} %"
    said.append(f"{sure}; {best.added[-1] if best.added else 'baseline'}")
    return best.rung.error, len(best.rung.fit.shared)


def main() -> None:
    """A line for each rig and peer."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path)
    folders = parser.parse_args().folders
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as temporary:
        rigs = folders or [simulated(name, Path(temporary) / name) for name in RIGS]
        for folder in rigs:
            campaign = read_campaign(folder)
            assert isinstance(campaign, ComponentCampaign)
            rig, known = Rig(campaign), None if folders else RIGS[folder.name]
            said = list[str]()
            peers: dict[str, Callable[[], Answer]] = {
                "wheelhop": partial(by_wheelhop, rig, said),
                "lmfit": partial(by_lmfit, rig),
                "PySINDy": partial(by_pysindy, rig),
            }
            if known is not None:
                peers["SciPy, told the law"] = partial(by_scipy, rig, known[0], known[1])
            for name, answer in peers.items():
                begin = time.process_time()
                error, count = answer()
                took, more = time.process_time() - begin, said.pop() if said else ""
                line = f"{folder.name:12} {name:20} {100 * error:6.2f} % {count:3} {took:6.1f} s"
                print(line, more, flush=True)


if __name__ == "__main__":
    main()
