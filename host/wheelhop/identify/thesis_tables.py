"""The tables of the thesis that hold no transfer function: bushings, components, tracks, roads; and
the quarter car that it compares its own with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.sync.beam import Beam
from wheelhop.campaign.proving_ground import proving_ground
from wheelhop.identify import published
from wheelhop.identify.equivalent import equivalent_vehicle, ground_to_body
from wheelhop.identify.row import UNPUBLISHED, Kind, Row, make_row
from wheelhop.identify.statespace import StateSpace
from wheelhop.material.model import ModulusModel
from wheelhop.material.models import (
    FractionalKelvinVoigt,
    FractionalZener,
    LogarithmicPolynomial,
    ModifiedPowerLaw,
)
from wheelhop.track.random_road import RandomRoad
from wheelhop.track.roughness import roughness

Array = NDArray[np.float64]

STEP_TIME_S: Array = np.arange(0.0, 3.0, 0.001)
MIDDLE_HZ = 5.5
"""Middle, by its logarithm, of the 1 to 30 Hz at which most bushings were tested."""
SMALL_BETA = "alike for small β, as (3.17) and (3.39) have it; β is 0.060 here"
STEEL_PA, STEEL_KG_M3, LOSS = 2e11, 7850.0, 0.02
GRAM_FORCE_N = 9.80665e-3
ROAD_M, ROAD_STEP_M, ROAD_SEEDS = 1000.0, 0.02, 8
"""The road that is made of Table 4.8: its length, its stations, and paths that are averaged."""


def table_rows() -> Iterator[Row]:
    """Rows of Tables 2.5, A.1, 3.2, 3.3, 4.1, 4.3 to 4.8, 5.1 and 5.4, of figures 2.21 and C.4."""
    yield from _quarter_car()
    yield from _bushings()
    yield from _components()
    yield from _tracks()
    yield from _pave()
    yield from _beam()


def usual_quarter_car() -> StateSpace:
    """Table 2.5's: from the ground to the body."""
    q = published.TABLE_2_5
    m, w = q["sprung_kg"], q["unsprung_kg"]
    k, c, kt, ct = (q[name] for name in ("strut_N_m", "strut_N_s_m", "tyre_N_m", "tyre_N_s_m"))
    # States x, y, x', and p = w y' - ct u, so that the ground's rate is no input.
    a = np.array(
        [
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1 / w],
            [-k / m, k / m, -c / m, c / m / w],
            [k, -k - kt, c, -(c + ct) / w],
        ]
    )
    b = np.array([[0.0], [ct / w], [c * ct / m / w], [kt - (c + ct) * ct / w]])
    return StateSpace(a, b, np.array([[1.0, 0.0, 0.0, 0.0]]), np.zeros((1, 1)))


def quarter_cars() -> dict[str, StateSpace]:
    """The two of figure 2.21, from the ground under a wheel to the body above it."""
    general = ground_to_body(equivalent_vehicle().body()).part(0, 0)
    return {"usual": usual_quarter_car(), "generalized": general}


def _quarter_car() -> Iterator[Row]:
    reason = "read off the figure"
    for name, car in quarter_cars().items():
        moved = car.step(STEP_TIME_S)[:, 0, 0]
        peak, end = published.FIGURE_2_21[name]
        usual = name == "usual"
        why = reason if usual else f"{reason}; {UNPUBLISHED}"
        kind: Kind = "recalculation" if usual else "prediction"
        yield make_row("fig 2.21", f"{name} quarter car, peak", peak, moved.max(), kind, why)
        kind = "recalculation" if usual else "fit"
        yield make_row("fig 2.21", f"{name} quarter car, final", end, car.static()[0, 0], kind, why)
    quarter = published.SPRUNG_MASS_KG / 4
    sprung = published.TABLE_2_5["sprung_kg"]
    yield make_row("2.5", "sprung mass, kg", sprung, quarter, "recalculation", "")
    new, wheel = published.TABLE_2_2["new"], published.TABLE_2_3["front"]
    again = {
        "strut_N_m": new[0],
        "strut_N_s_m": new[2],
        "unsprung_kg": wheel[0],
        "tyre_N_m": wheel[1],
        "tyre_N_s_m": wheel[2],
    }
    for name, ours in again.items():
        what = f"{name}, in 2.2 and 2.3"
        yield make_row("2.5", what, published.TABLE_2_5[name], ours, "taken over", "")
    names = ("K front", "K rear", "C front", "C rear")
    for name, first, old in zip(
        names, published.TABLE_A_1, published.TABLE_2_2["old"], strict=True
    ):
        yield make_row("A.1", f"{name}, in 2.2", first, old, "taken over", "")


def _bushings() -> Iterator[Row]:
    """Both models of a specimen are fitted to the same points: their moduli must be alike. Printed
    stands for the logarithmic polynomial, or Kelvin–Voigt's model, and ours for the power law."""
    omega = np.array([2 * np.pi * MIDDLE_HZ])
    reason = "two models, each with three numbers, of the same points"
    for i, numbers in enumerate(published.TABLE_3_2):
        power, polynomial = np.array(numbers[:3]), np.array(numbers[3:])
        one = ModifiedPowerLaw().modulus(omega, power)[0]
        other = LogarithmicPolynomial().modulus(omega, polynomial)[0]
        name = f"bushing {1 + i // 2}.{1 + i % 2}"
        for what, a, b in (("stiffness", one.real, other.real), ("loss", one.imag, other.imag)):
            label = f"{name}, {what}, {MIDDLE_HZ:g} Hz, N/mm"
            yield make_row("3.2", label, b, a, "recalculation", reason)
        what = f"{name}, A₀ + M₀, of the other model A₀"
        yield make_row("3.2", what, polynomial[0], power[0] + power[2], "recalculation", SMALL_BETA)
    yield from _three_models(omega)


def _three_models(omega: Array) -> Iterator[Row]:
    """Of one specimen, the two fractional models as printed, and the modified power law, with the
    digits of Table 3.2, as ours."""
    of = {name: np.array(numbers) for name, numbers in published.TABLE_3_3.items()}
    power = np.array(published.TABLE_3_2[0][:3])
    ours = ModifiedPowerLaw().modulus(omega, power)[0]
    others: Mapping[str, ModulusModel] = {
        "fractional Kelvin-Voigt": FractionalKelvinVoigt(),
        "four-parameter fractional": FractionalZener(),
    }
    reason = "models of unlike form whose fits are not alike good: J is 0.14, 0.07, and 0.05 here"
    for name, model in others.items():
        theirs = model.modulus(omega, of[name])[0]
        for part, a, b in (("stiffness", theirs.real, ours.real), ("loss", theirs.imag, ours.imag)):
            what = f"{name}, {part}, {MIDDLE_HZ:g} Hz, N/mm"
            yield make_row("3.3", what, a, b, "recalculation", reason)
    for what, printed, digits in zip(
        ("A₀", "β", "M₀"), of["modified power law"], power, strict=True
    ):
        label = f"modified power law, {what}, in 3.2"
        yield make_row("3.3", label, printed, digits, "taken over", "printed with two digits here")


def _components() -> Iterator[Row]:
    """Stiffness and damping go to the wheel by one and the same square of the motion ratio."""
    for end, (k, c, k_wheel, c_wheel) in published.TABLE_4_1.items():
        what = f"{end}, damping at the wheel, N·s/m"
        yield make_row("4.1", what, c_wheel, c * k_wheel / k, "recalculation", "")
        strut = published.TABLE_5_4["old"]
        again = strut[0 if end == "front" else 1]
        yield make_row("4.1", f"{end}, stiffness in Table 5.4", k_wheel, again, "taken over", "")
    quantities = ("unsprung mass, kg", "tyre, N/m", "its damping, N·s/m")
    for end, numbers in published.TABLE_4_3.items():
        for what, printed, ours in zip(quantities, numbers, published.TABLE_5_3[end], strict=True):
            yield make_row("4.3", f"{end}, {what}, in 5.3", printed, ours, "taken over", "")
    for i, end in enumerate(("front", "rear")):
        old, new = (published.TABLE_5_4[key][i] for key in ("old", "new"))
        yield make_row("5.4", f"{end}, 20 % stiffer, N/m", new, 1.2 * old, "recalculation", "")


def _tracks() -> Iterator[Row]:
    ground = proving_ground()
    for name, (amplitude, pitch) in published.TABLE_4_4.items():
        keys = ground[name].keys
        for what, printed in (("amplitude", amplitude), ("pitch", pitch)):
            ours = float(keys[f"{what}_mm"])
            yield make_row("4.4", f"{name}, {what}, mm", printed, ours, "taken over", "")
    for name, keys in published.OTHER_TRACKS.items():
        table = "4.4" if name.startswith("sine") else "4.3.3"
        for key, printed in keys.items():
            what = f"{name}, {key.removesuffix('_mm').replace('_', ' ')}, mm"
            yield make_row(table, what, printed, float(ground[name].keys[key]), "taken over", "")
    tables: dict[str, Mapping[str, Sequence[float]]] = {
        **published.TABLES_4_5_TO_4_7,
        "5.1": published.TABLE_5_1,
    }
    for table, tracks in tables.items():
        for name, speeds in tracks.items():
            pairs = zip(speeds, ground[name].speeds_kmph, strict=True)
            for number, (printed, ours) in enumerate(pairs, start=1):
                what = f"{name}, speed {number}, km/h"
                yield make_row(table, what, printed, ours, "taken over", "")


def _pave() -> Iterator[Row]:
    """A road is made of C and w, and both are found in it again."""
    c, w = published.TABLE_4_8
    place = np.arange(0.0, ROAD_M, ROAD_STEP_M)
    heights = [RandomRoad(c, w, seed).elevation(place, 0.0) for seed in range(ROAD_SEEDS)]
    found = roughness(np.column_stack(heights), ROAD_STEP_M)
    reason = f"of {ROAD_SEEDS} roads of {ROAD_M:g} m, which are random"
    yield make_row("4.8", "C, m³", c, found.unevenness_m3, "round trip", reason)
    yield make_row("4.8", "w", w, found.waviness, "round trip", reason)


def _beam() -> Iterator[Row]:
    """Appendix C's ruler, its sensors without mass: it says that damping does not matter at 15 Hz,
    which holds where a loss factor of steel in a clamp moves the free end by as good as nothing."""
    length, width, height = published.BEAM_M
    ruler = Beam.rectangular(length, width, height, STEEL_PA, STEEL_KG_M3)
    still, damped = (
        abs(ruler.receptance(published.BEAM_HZ, length, length, loss).item())
        for loss in (0.0, LOSS)
    )
    what = f"free end at 15 Hz, loss factor {LOSS:g} over none"
    yield make_row("C.4", what, 1.0, damped / still, "recalculation", "")
    footnote = "printed with ≈"
    ours = published.BEAM_FORCE_GF * GRAM_FORCE_N
    yield make_row("C.4", "100 gf, N", 1.0, ours, "recalculation", footnote)
