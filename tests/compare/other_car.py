"""A half car in the frequency domain, which shares no code with the model: an accelerometer on its
body, over rough ground or single bumps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RATE_HZ, FINER, AHEAD_S = 100.0, 4, 4.0
GRID_M, SHORTEST_M = 0.02, 0.25
FRONT_M, REAR_M = 1.1, 1.3


@dataclass(frozen=True)
class Car:
    """Mass, pitch inertia, natural frequency and damping ratio of the body on its springs,
    unsprung mass per body mass, tyre per spring stiffness, and where the sensor sits."""

    mass_kg: float
    inertia_kg_m2: float
    body_hz: float
    damping: float
    unsprung: float
    tyre: float
    sensor_m: float

    @staticmethod
    def drawn(rng: np.random.Generator) -> Car:
        mass = rng.uniform(200.0, 1200.0)
        return Car(
            mass,
            mass * rng.uniform(0.9, 1.3) * FRONT_M * REAR_M,
            rng.uniform(1.2, 2.2),
            rng.uniform(0.15, 0.4),
            rng.uniform(0.06, 0.15),
            rng.uniform(6.0, 10.0),
            rng.uniform(-0.5, 0.5),
        )

    def matrices(self, dampers: float) -> tuple[np.ndarray, ...]:
        """M, C, K (4, 4) of heave, pitch (nose up) and both axles, and the tyres' stiffnesses."""
        base = FRONT_M + REAR_M
        mass = np.array([REAR_M, FRONT_M]) / base * self.mass_kg
        spring = mass * (2 * np.pi * self.body_hz * np.array([1.0, 1.1])) ** 2
        damper = dampers * 2 * self.damping * np.sqrt(spring * mass)
        tyre, unsprung = self.tyre * spring, self.unsprung * self.mass_kg
        k, c = np.diag([0.0, 0.0, *tyre]), np.zeros((4, 4))
        for axle, arm in enumerate((FRONT_M, -REAR_M)):
            row = np.array([1.0, arm, 0.0, 0.0])
            row[2 + axle] = -1.0
            k += spring[axle] * np.outer(row, row)
            c += damper[axle] * np.outer(row, row)
        return np.diag([self.mass_kg, self.inertia_kg_m2, unsprung, unsprung]), c, k, tyre

    def body_damping(self, dampers: float = 1.0) -> float:
        """Mean damping ratio of the two modes of the body."""
        m, c, k, _ = self.matrices(dampers)
        lower = np.hstack([-np.linalg.solve(m, k), -np.linalg.solve(m, c)])
        poles = np.linalg.eigvals(np.vstack([np.eye(4, 8, 4), lower]))
        poles = sorted(poles[poles.imag > 0], key=abs)[:2]
        return float(np.mean([-pole.real / abs(pole) for pole in poles]))

    def drive(
        self,
        ground: np.ndarray,
        speed_m_s: float,
        seconds: float,
        rng: np.random.Generator,
        dampers: float = 1.0,
        noise: float = 0.1,
    ) -> np.ndarray:
        """What the accelerometer shows (n,), m/s², in a drive that begins within 3 m."""
        rate, ahead = FINER * RATE_HZ, round(AHEAD_S * FINER * RATE_HZ)
        time_s = np.arange(round(seconds * rate) + ahead) / rate
        x = 5.0 + rng.uniform(0.0, 3.0) + speed_m_s * time_s
        along = GRID_M * np.arange(len(ground))
        heights = [np.interp(x - behind, along, ground) for behind in (0.0, FRONT_M + REAR_M)]
        size = 2 * len(x)
        spectra = np.fft.rfft(np.array(heights) * np.minimum(time_s / 2.0, 1.0), size)
        frequency = np.fft.rfftfreq(size, 1.0 / rate)
        kept = frequency < 0.48 * RATE_HZ  # the recorder's filter, before it is sampled
        s, heard = 2j * np.pi * frequency[kept], spectra[:, kept]
        m, c, k, tyre = self.matrices(dampers)
        dynamic = s[:, None, None] ** 2 * m + s[:, None, None] * c + k
        pushed = np.zeros((len(s), 4, 1), complex)
        pushed[:, 2, 0], pushed[:, 3, 0] = tyre[:, None] * heard
        moved = np.linalg.solve(dynamic, pushed)[:, :, 0]
        spectrum = np.zeros(len(frequency), complex)
        spectrum[kept] = s**2 * (moved[:, 0] + self.sensor_m * moved[:, 1])
        shown = np.fft.irfft(spectrum, size)[ahead : len(x) : FINER]
        return shown + noise * rng.normal(size=len(shown))


def rough(rng: np.random.Generator, length_m: float) -> np.ndarray:
    """Ground with a slope that is white down to what a tyre swallows."""
    count = int(length_m / GRID_M)
    wave = np.fft.rfftfreq(count, GRID_M)
    wave[0] = np.inf
    size = 1.0 / (wave * np.sqrt(1.0 + (wave * SHORTEST_M) ** 8))
    drawn = size * (rng.normal(size=len(wave)) + 1j * rng.normal(size=len(wave)))
    height = np.fft.irfft(drawn, count)
    return height * (0.012 * np.sqrt(length_m / 30.0) / height.std())


def bumps(speed_m_s: float, seconds: float, count: int = 3) -> np.ndarray:
    """Smooth ground with bumps, 5 cm high and half a metre long, evenly in time."""
    along = np.arange(0.0, 1.2 * speed_m_s * (seconds + AHEAD_S) + 30.0, GRID_M)
    ground = np.zeros_like(along)
    for place in (np.arange(count) + 0.3) / count:
        off = along - (15.0 + speed_m_s * (AHEAD_S + seconds * place))
        on_it = np.abs(off) < 0.25
        ground[on_it] += 0.05 * np.cos(np.pi * off[on_it] / 0.5) ** 2
    return ground
