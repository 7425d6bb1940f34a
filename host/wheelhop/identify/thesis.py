"""The thesis recomputed: every number of chapters 2 and 5 that can be, beside the printed one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.identify import published
from wheelhop.identify.equivalent import (
    STEP_TIME_S,
    equivalent_vehicle,
    ground_to_body,
    step_responses,
    wheels,
)
from wheelhop.identify.identify import identify
from wheelhop.identify.quarter_car import (
    Struts,
    Wheels,
    compliance,
    on_wheels,
    other_suspensions,
    wheel_hop_hz,
)
from wheelhop.identify.statespace import StateSpace, balanced_reduction
from wheelhop.identify.steps import fit_damped_sinusoids, incremental_model
from wheelhop.identify.structure import Structure
from wheelhop.identify.synthetic import thesis_matrix, thesis_runs

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Row:
    """One number: where it is printed, what it is, the printed value, ours (NaN: there is none),
    and why they differ (empty: they agree to 1 %)."""

    table: str
    what: str
    printed: float
    ours: float
    reason: str


def thesis_rows() -> list[Row]:
    """All rows, in the order of the thesis. Takes some seconds."""
    body = equivalent_vehicle().body()
    return [
        *_table_2_1(body),
        *_table_2_4(body),
        *_reduced(body),
        *_figure_2_15(body),
        *_table_5_2(),
        *_chapter_5(),
        *_table_d_1(),
    ]


UNPUBLISHED = (
    "the frame's finite elements are not printed; an equivalent rigid body with one twisting mode"
    " stands for them"
)
FIRST_GUESS = {
    1: "from the step at B1 alone, with which section 2.4 begins (all four give nothing that"
    " oscillates): one increment at four points cannot hold four modes, and hangs on those of the"
    " frame that are not printed; with one bending mode the step at B1 gives it within 4 %"
    " (benchmarks/table_a2.py)",
    2: "of a frame with more modes than the equivalent vehicle's one: two increments at four points"
    " hold four modes, so with no more of them two and three would print the same pairs. With one"
    " bending mode the step at B1 gives two increments within 10 %, three within 25 %"
    " (benchmarks/table_a2.py)",
}
"""By number of increments in the state."""


def _row(table: str, what: str, printed: float, ours: float, reason: str) -> Row:
    agrees = abs(ours - printed) <= 0.01 * abs(printed)
    return Row(table, what, printed, float(ours), "" if agrees else reason)


def _table_2_1(body: StateSpace) -> Iterator[Row]:
    responses = step_responses(body)
    for count, pairs in published.TABLE_2_1.items():
        fitted = fit_damped_sinusoids(STEP_TIME_S, responses, count, starts_at_rest=False)
        reason = UNPUBLISHED
        if count == 3:
            reason = "the vehicle has a fourth mode, whose motion three sinusoids share out"
        yield from _pairs("2.1", count, pairs, fitted.sigma, fitted.omega, reason)
    for count, pairs in published.TABLE_A_2.items():
        sigma, omega = incremental_model(STEP_TIME_S, responses[:1], count)
        yield from _pairs("A.2", count, pairs, sigma, omega, FIRST_GUESS[min(count, 2)])


def _pairs(
    table: str,
    count: int,
    printed: tuple[tuple[float, float], ...],
    sigma: Array,
    omega: Array,
    reason: str,
) -> Iterator[Row]:
    """Each printed pair beside the one of ours that is nearest, no one of ours used twice; NaN
    where ours are fewer."""
    left = list(zip(sigma.tolist(), omega.tolist(), strict=True))
    for number, pair in enumerate(printed, start=1):
        near = (float("nan"), float("nan"))
        if left:
            near = min(left, key=lambda p: abs(complex(*p) - complex(*pair)))
            left.remove(near)
        for name, theirs, ours in zip(("σ", "ω"), pair, near, strict=True):
            yield _row(table, f"{count} sinusoids, {name}{number}, 1/s", theirs, ours, reason)


def _table_2_4(body: StateSpace) -> Iterator[Row]:
    strut = published.TABLE_2_2["new"][0]
    tyre = published.TABLE_2_3["front"][1]
    for mass, simple, model in published.TABLE_2_4:
        ours = wheel_hop_hz(mass, tyre, strut)
        yield _row("2.4", f"wheel hop by (2.27), {mass:g} kg, Hz", simple, ours, "")
        hop = _frequencies(balanced_reduction(ground_to_body(body, mass).part(0, 0), 6)[0])[-1]
        yield _row("2.4", f"wheel hop of G_red, {mass:g} kg, Hz", model, hop, UNPUBLISHED)


def _reduced(body: StateSpace) -> Iterator[Row]:
    g = ground_to_body(body).part(0, 0)
    ours = _frequencies(balanced_reduction(g, 6)[0])
    theirs = np.sort(np.abs([p for p in np.roots(published.G_RED[1]) if p.imag > 0])) / (2 * np.pi)
    for number, (printed, here) in enumerate(zip(theirs, ours, strict=True), start=1):
        yield _row("A.4", f"pole {number} of G_red, Hz", float(printed), here, UNPUBLISHED)
    static = published.G_11_STATIC[0] / published.G_11_STATIC[1]
    yield _row("A.4", "G11(0)", static, g.static()[0, 0], UNPUBLISHED)
    reduced = published.G_RED[0][-1] / published.G_RED[1][-1]
    ours_reduced = balanced_reduction(g, 6)[0].static()[0, 0]
    yield _row("A.4", "G_red(0)", reduced, ours_reduced, UNPUBLISHED)


def _figure_2_15(body: StateSpace) -> Iterator[Row]:
    old, new = (Struts(*published.TABLE_2_2[key]) for key in ("old", "new"))
    for factor in (1.0, 1.25, 1.5):
        struts = Struts(factor * new.front_N_m, new.rear_N_m, new.front_N_s_m, new.rear_N_s_m)
        static = on_wheels(body, old, struts, wheels()).static()[0, 0]
        reason = 'read off a figure and printed as "close to 0.8"; (A.4) says 0.76 for the first'
        yield _row("fig 2.15", f"static, front stiffness × {factor:g}", 0.8, static, reason)


def _table_5_2() -> Iterator[Row]:
    denominator = published.TABLE_5_2.denominator()
    for power, printed in enumerate(published.D2_DENOMINATOR[::-1]):
        ours = float(denominator[8 - power])
        if power < 8:
            reason = "printed with one or two digits"
            yield _row("D.2", f"denominator, s^{power}, of Table 5.2", float(printed), ours, reason)
    h = identify(
        [thesis_runs(noise=0.01)], Structure("symmetric", rigid=False), start=None, order=8
    )
    truth = published.TABLE_5_2
    found = h.sections.sorted()
    reason = "from runs made of (D.2) with 1 % noise: beyond what they can tell"
    for k in range(4):
        yield _row("5.2", f"mode {k + 1}, Hz", truth.frequency_hz[k], found.frequency_hz[k], reason)
        yield _row("5.2", f"mode {k + 1}, ζ", truth.zeta[k], found.zeta[k], reason)


def _chapter_5() -> Iterator[Row]:
    old, new = (Struts(*published.TABLE_5_4[key]) for key in ("old", "new"))
    body = compliance(thesis_matrix(), old)
    front, rear = published.TABLE_5_3["front"], published.TABLE_5_3["rear"]
    masses, stiffness, damping = zip(front, rear, strict=True)
    g = on_wheels(body, old, new, Wheels(masses, stiffness, damping)).part(0, 0)
    printed = published.H_N_11_STATIC[0] / published.H_N_11_STATIC[1]
    sign = "B of (5.22) was used with the opposite sign: raising a wheel would lower the body"
    yield _row("D.2.2", "H_n,11(0)", printed, g.static()[0, 0], sign)
    reduced = published.H_RED[0][-1] / published.H_RED[1][-1]
    ours, _ = balanced_reduction(g, 8)
    yield _row("D.2.2", "H_red(0)", reduced, ours.static()[0, 0], sign)
    theirs = np.roots(published.H_RED[1])
    theirs = theirs[theirs.imag > 0]
    reason = "of an order reduced from printed coefficients of one or two digits"
    for number, (a, b) in enumerate(
        zip(np.sort(np.abs(theirs)), 2 * np.pi * _frequencies(ours), strict=True), start=1
    ):
        yield _row("D.2.2", f"pole {number} of H_red, Hz", a / 2 / np.pi, b / 2 / np.pi, reason)
    rows = thesis_matrix().static().sum(axis=1)
    truth = "printed as fitted; with all wheels raised the body must rise as much"
    rigid = other_suspensions(body, old, new)
    yield Row("D.2.1", "rows of H(0), front", 1.0, float(rows[0]), truth)
    yield Row("D.2.1", "rows of H(0), rear", 1.0, float(rows[2]), truth)
    assert rigid.order == body.order


def _table_d_1() -> Iterator[Row]:
    component, unsprung = 15e3, published.TABLE_5_3["rear"]
    reason = "the printed one takes the component's stiffness, 15 N/mm; this the wheel rate"
    printed = published.TABLE_D_1["wheel hop"]
    yield _row(
        "D.1",
        "wheel hop, rear, component's stiffness, Hz",
        printed,
        wheel_hop_hz(unsprung[0], unsprung[1], component),
        "",
    )
    for end in ("rear", "front"):
        mass, tyre, _ = published.TABLE_5_3[end]
        strut = published.TABLE_5_4["old"][0 if end == "front" else 1]
        ours = wheel_hop_hz(mass, tyre, strut)
        yield _row("D.1", f"wheel hop, {end}, wheel rate, Hz", printed, ours, reason)
    mass, pitch, roll = implied_body()
    unprinted = (
        "inertias are not printed; ours are those of the examples' vehicle with its driver. On the"
        " components' springs, as the printed wheel hop takes them, a body of"
        f" {mass:.0f} kg, {pitch:.0f} and {roll:.0f} kg m² has the three printed frequencies"
    )
    for mode, ours in simple_modes().items():
        yield _row("D.1", f"{mode}, Hz", published.TABLE_D_1[mode], ours, unprinted)
    bare = published.ATV_MASS_KG - 2 * sum(published.TABLE_5_3[e][0] for e in ("front", "rear"))
    driverless = (
        "printed: the vehicle less its wheels. Table D.1 is of the vehicle without its driver, if"
        " the centre of mass is where the examples have it"
    )
    yield _row("D.1", "sprung mass of these modes, kg", bare, mass, driverless)
    frame = "of an Adams model whose tubes are not printed: nothing to compute it from"
    yield _row("D.1", "twist, Hz", published.TABLE_D_1["twist"], float("nan"), frame)


def _vertical() -> tuple[float, float, float, float]:
    """Stiffness, N/m, coupling, N, and stiffness in pitch and in roll, N·m, of the components'
    springs about the centre of mass (thesis D.1 and D.4)."""
    car = published.ATV
    front, rear = 2 * car["front_N_m"], 2 * car["rear_N_m"]
    ahead, behind = car["cg_to_front_axle_m"], car["wheelbase_m"] - car["cg_to_front_axle_m"]
    coupling, pitch = rear * behind - front * ahead, front * ahead**2 + rear * behind**2
    return front + rear, coupling, pitch, (front + rear) * (car["track_width_m"] / 2) ** 2


def simple_modes() -> dict[str, float]:
    """Pitch, bounce and roll, Hz, by thesis D.3 and D.4 with the components' stiffnesses."""
    car = published.ATV
    mass, inertia = car["mass_kg"], car["pitch_inertia_kg_m2"]
    heave, coupling, pitch, roll = _vertical()
    alpha, gamma = heave / mass, pitch / inertia
    middle = (alpha + gamma) / 2
    root = np.sqrt(((alpha - gamma) / 2) ** 2 + coupling**2 / (mass * inertia))
    return {
        "pitch": float(np.sqrt(middle - root) / (2 * np.pi)),
        "bounce": float(np.sqrt(middle + root) / (2 * np.pi)),
        "roll": float(np.sqrt(roll / car["roll_inertia_kg_m2"]) / (2 * np.pi)),
    }


def implied_body() -> tuple[float, float, float]:
    """Mass, kg, inertia in pitch and in roll, kg m², that have the printed pitch, bounce and roll:
    `simple_modes` solved for them, the heavier of two bodies."""
    heave, coupling, pitch, roll = _vertical()
    squares = {k: (2 * np.pi * published.TABLE_D_1[k]) ** 2 for k in ("pitch", "bounce", "roll")}
    # α + γ = ω₁² + ω₂² and α γ - β² M/I = ω₁² ω₂², with α = heave/M and γ = pitch/I.
    both = (heave * pitch - coupling**2) / (squares["pitch"] * squares["bounce"])  # M · I
    total = squares["pitch"] + squares["bounce"]
    mass = float(np.roots([pitch / both, -total, heave]).real.max())
    return mass, both / mass, roll / squares["roll"]


def _frequencies(system: StateSpace) -> Array:
    """Natural frequencies of the oscillating poles, Hz, lowest first."""
    poles = system.poles()
    return np.asarray(np.sort(np.abs(poles[poles.imag > 1e-9])) / (2 * np.pi))
