"""Make `examples/bushings`: the specimens of Table 3.2, and what a rig would measure of them.

The measurements of the source are not published, its fitted parameters are. Moduli are those of
the modified power law with 1 % noise; the signals are the force of Maxwell elements, solved by
scipy, under sine steps of two amplitudes: python docs/make_bushing_examples.py
"""

from pathlib import Path

import numpy as np
from scipy import signal

from wheelhop.material import ModifiedPowerLaw, Specimen, approximate, write_specimen

FOLDER = Path(__file__).parents[1] / "examples/bushings"
# Bushing, specimen, highest frequency in Hz (Table 3.1), A0 N/mm, beta, M0 N/mm (Table 3.2).
TABLE = (
    (1, 1, 30, 529.720, 0.056, 485.635),
    (1, 2, 30, 649.802, 0.048, 355.167),
    (2, 1, 30, 855.702, 0.090, 44.132),
    (2, 2, 30, 894.934, 0.089, -54.369),
    (3, 1, 25, 517.930, 0.060, -109.340),
    (3, 2, 25, 365.390, 0.078, 23.210),
    (4, 1, 50, 441.464, 0.060, 132.586),
    (4, 2, 50, 433.754, 0.050, 185.934),
)
NOISE = 0.01
RATE_HZ = 500.0
STEPS_HZ = (1.0, 2.0, 5.0, 10.0, 20.0, 30.0)
AMPLITUDE_M = 0.5e-3  # 1 mm peak to peak
CYCLES = 6


def main() -> None:
    """Write every file."""
    FOLDER.mkdir(exist_ok=True)
    draw = np.random.default_rng(32)
    specimens = []
    for bushing, number, highest, a0, beta, m0 in TABLE:
        parameters = np.array([1e3 * a0, beta, 1e3 * m0])
        specimen = Specimen(
            f"bushing {bushing}, specimen {number}",
            ModifiedPowerLaw(),
            parameters,
            (1.0, float(highest)),
        )
        specimens.append(specimen)
        name = f"bushing-{bushing}-specimen-{number}"
        write_specimen(FOLDER / f"{name}.toml", specimen)
        frequency = np.arange(1.0, highest + 1)
        exact = specimen.modulus(2 * np.pi * frequency) / 1e3
        noise = 1 + NOISE * draw.normal(size=(2, len(frequency)))
        rows = [
            f"{f:g},{d:.3f},{m:.3f}"
            for f, d, m in zip(frequency, exact.real * noise[0], exact.imag * noise[1], strict=True)
        ]
        text = "frequency_hz,dynamic_N_mm,loss_N_mm\n" + "\n".join(rows) + "\n"
        (FOLDER / f"{name}.csv").write_text(text, encoding="utf-8")
    _write_signals(specimens[0])


def _write_signals(specimen: Specimen) -> None:
    pieces = [np.zeros(50)]
    for f in STEPS_HZ:
        phase = 2 * np.pi * f * np.arange(round(CYCLES / f * RATE_HZ)) / RATE_HZ
        pieces += [AMPLITUDE_M * np.sin(phase), np.zeros(100)]
    x = np.concatenate(pieces)
    time = np.arange(len(x)) / RATE_HZ
    elements = approximate(specimen.modulus)
    force = elements.stiffness_N_m * x + elements.damping_N_s_m * np.gradient(x, time)
    for strength, tau in zip(elements.strengths_N_m, elements.times_s, strict=True):
        force += signal.lsim(([strength * tau, 0.0], [tau, 1.0]), x, time)[1]
    force += np.random.default_rng(33).normal(0.0, 1.0, len(x))
    rows = "\n".join(
        f"{t:.3f},{1e3 * moved:.5f},{pushed:.2f}"
        for t, moved, pushed in zip(time, x, force, strict=True)
    )
    text = f"time_s,displacement_mm,force_N\n{rows}\n"
    (FOLDER / "signals-1-1.csv").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
