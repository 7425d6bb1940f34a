"""A vehicle at rest whose corners are struck one after the other, and what the logger makes of it.

The vehicle is a rigid body on four corners with axles on tyres, written down here by itself.

    python -m tests.calibration.strikes 300

prints how many of so many vehicles the checklist judges rightly, one of them with two plugs
exchanged and a sensor upside down in turn with one that is as it should be.
"""

import sys

import numpy as np
from scipy.linalg import expm
from scipy.signal import lfilter

from wheelhop.calibration.health.checklist import check_commissioning
from wheelhop.logger.recording import CODE, Channel, Recording

POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
CODES_PER_M_S2 = 19.5 / 9.81
FINE_HZ = 3200.0
REST_S, STRIKE_S = 12.0, 3.0
NOTES = {
    "device": "3", "firmware": "1.0.0", "calibration": "cal-1", "rate_hz": "100",
    "supply_mv": "3300", "end_supply_mv": "3297", "reset": "power", "clock_ppm": "-812",
    "end": "button", "lost": "0", "late": "0", "card_errors": "0", "config_errors": "0",
    "stall_ms": "41", "deepest": "4", "room": "74",
}  # fmt: skip


def vehicle(draw):
    """Acceleration (8,) of the points = C x + D f for dx/dt = A x + B f: forces f (8,) at them."""
    mass, roll, pitch = draw.uniform(150, 350), draw.uniform(15, 60), draw.uniform(60, 160)
    front, rear, half = draw.uniform(0.5, 0.9), draw.uniform(0.5, 0.9), draw.uniform(0.5, 0.7)
    corners = [(front, half), (front, -half), (-rear, half), (-rear, -half)]
    shape = np.zeros((8, 7))  # of the points, by heave, roll, pitch and the axles
    for k, (x, y) in enumerate(corners):
        shape[k, :3] = 1.0, y, -x
    shape[4:, 3:] = np.eye(4)
    masses = np.diag([mass, roll, pitch, *draw.uniform(8, 25, 4)])
    strut = shape[:4] - shape[4:]
    stiffness = strut.T @ np.diag(draw.uniform(8e3, 25e3, 4)) @ strut
    stiffness += shape[4:].T @ np.diag(draw.uniform(4e4, 1.2e5, 4)) @ shape[4:]
    damping = strut.T @ np.diag(draw.uniform(300, 2000, 4)) @ strut
    damping += shape[4:].T @ (np.eye(4) * 60.0) @ shape[4:]
    inverse = np.linalg.inv(masses)
    a = np.block([[np.zeros((7, 7)), np.eye(7)], [-inverse @ stiffness, -inverse @ damping]])
    b = np.vstack([np.zeros((7, 8)), inverse @ shape.T])
    return a, b, shape @ a[7:], shape @ b[7:]


def codes(seed, *, order=range(8), inverted=(), impulse=(1.0, 4.0)):
    """Codes (n, 8) at `FINE_HZ` behind the sensors' 50 Hz: rest, then strikes downwards at the
    points, 3 s apart, in `order`; `inverted` are the points whose sensor is upside down.
    """
    draw = np.random.default_rng(seed)
    a, b, c, d = vehicle(draw)
    whole = expm(np.block([[a, b], [np.zeros((8, 22))]]) / FINE_HZ)
    step, push = whole[:14, :14], whole[:14, 14:]
    count, rows = len(order), round(STRIKE_S * FINE_HZ)
    force = np.zeros((rows, 8, count))  # each strike by itself: the one before has died away
    for k, point in enumerate(order):
        length = round(draw.uniform(0.002, 0.008) * FINE_HZ)
        start = round(draw.uniform(0, 0.5) * FINE_HZ)
        bell = np.sin(np.pi * (np.arange(length) + 0.5) / length)
        force[start : start + length, point, k] = (
            -draw.uniform(*impulse) * bell / bell.sum() * FINE_HZ
        )
    rest = round(REST_S * FINE_HZ)
    state, moved = np.zeros((14, count)), np.zeros((rest + count * rows, 8))
    for row, f in enumerate(force):
        moved[rest + row + np.arange(count) * rows] = (c @ state + d @ f).T
        state = step @ state + push @ f
    felt = moved * CODES_PER_M_S2 * draw.uniform(0.9, 1.1, 8)
    felt[:, list(inverted)] *= -1
    keep = np.exp(-2 * np.pi * 50.0 / FINE_HZ)
    return lfilter([1 - keep], [1, -keep], felt, axis=0) + draw.uniform(480, 580, 8)


def struck(seed, *, channels=range(8), rate_hz=100, notes=NOTES, **how):
    """The session as the logger records it; plug k is in the sensor at point `channels[k]`."""
    felt = codes(seed, **how)[:, list(channels)]
    window = round(FINE_HZ / rate_hz)
    means = felt[: len(felt) // window * window].reshape(-1, window, 8).mean(axis=1)
    means += 0.05 * np.random.default_rng(seed).normal(size=means.shape)
    names = tuple(Channel(point, CODE) for point in POINTS)
    return Recording(np.round(8 * means) / 8, float(rate_hz), names, notes=notes)


def main(vehicles: int) -> None:
    """Judge, count and print."""
    verdicts = {}
    for seed in range(vehicles):
        channels, inverted = list(range(8)), ()
        if seed % 2:
            one, other, third = np.random.default_rng(seed).choice(8, 3, replace=False)
            channels[one], channels[other], inverted = other, one, (third,)
        *_, places, upright = check_commissioning(
            struck(seed, channels=channels, inverted=inverted)
        )
        felt = " ".join(POINTS[k] for k in np.argsort(channels))
        seen = "open" if places.verdict == "open" else f"felt by {felt} (" in places.seen
        rose = [f"{POINTS[channels.index(k)]} rose" in "".join(upright.remedies) for k in inverted]
        way_up = all(rose) if inverted else upright.verdict == "pass"
        kind = "faulty" if seed % 2 else "good"
        verdicts[kind, seen, way_up] = verdicts.get((kind, seen, way_up), 0) + 1
    for (kind, seen, way_up), count in sorted(verdicts.items(), key=str):
        print(f"{kind}: {count} with places {seen}, polarity {way_up}")


if __name__ == "__main__":
    main(int(sys.argv[1]))
