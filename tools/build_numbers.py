"""Print the figures of firmware/BUILD.md, each computed from what it depends on.

    python tools/build_numbers.py

tests/firmware/test_build_guide.py holds the page to them.
"""

from math import cos, exp, hypot, pi, radians, sin, sqrt

import numpy as np

from wheelhop.logger.correct import sensor_response, window_response

AREF_V, CODES = 3.3, 1024
CODES_PER_G = 19.5  # 57 mV/g at 3 V, ratiometric: 62.7 mV/g at 3.3 V
SENSOR_A = 350e-6
OUTPUT_OHM, OUTPUT_F = 32e3, 0.1e-6
SUPPLY_OHM, INPUT_OHM, INPUT_F = 100.0, 10e3, 1e-9
BATTERY_V = 14.4  # a car's, being charged
CONVERTER_F = 14e-12  # sample and hold of the ATmega328P
TRACKING_S = 50e-6  # from the change of the input to its sampling, the interrupt taken off
CABLE_F_PER_M, CABLE_M = 150e-12, 3.0
BAND_HZ = 30.0
LINE_HZ = 60.0  # an engine at 3600 turns a minute


def left_dB(frequency_hz: float, rate_hz: int, corner_hz: float = 50.0) -> float:
    """How far a sine is down at least, of the eight inputs, behind sensor's filter and mean."""
    at = np.array([frequency_hz])
    windows = [window_response(at, 800 // rate_hz, k) for k in range(8)]
    left = np.abs(windows) * np.abs(sensor_response(at, corner_hz))
    return float(-20 * np.log10(left.max()))


def line_left(rate_hz: int) -> str:
    """What is left of the engine's line: the least and the most that it is down, by input."""
    at = np.array([LINE_HZ])
    left = [window_response(at, 800 // rate_hz, k) * sensor_response(at, 50.0) for k in range(8)]
    down = -20 * np.log10(np.abs(left))
    return f"{down.min():.1f} to {down.max():.1f} dB"


def least_folded(rate_hz: int) -> tuple[float, float]:
    """The line that comes through best of all that land below `BAND_HZ`, Hz, and how far down."""
    lines = np.arange(rate_hz - BAND_HZ, 2000.0, 0.5)
    folded = np.abs(lines - rate_hz * np.round(lines / rate_hz))
    return min(((f, left_dB(f, rate_hz)) for f in lines[folded <= BAND_HZ]), key=lambda x: x[1])


def bracket_hz(length_m: float, width_m: float, thickness_m: float, mass_kg: float) -> float:
    """First natural frequency of a mass on a strip of aluminium clamped at the other end."""
    stiffness = 3 * 70e9 * width_m * thickness_m**3 / 12 / length_m**3
    return sqrt(stiffness / mass_kg) / (2 * pi)


def input_error(volts: float) -> float:
    """Codes by which a neighbour that differs by so much shifts an input behind R and C."""
    shared = CONVERTER_F / (INPUT_F + CONVERTER_F)
    return CODES / AREF_V * volts * shared * exp(-TRACKING_S / (INPUT_OHM * INPUT_F))


def numbers() -> dict[str, str]:
    """What each figure is, and the figure as the page has it."""
    drop_v = SENSOR_A * SUPPLY_OHM
    short_a = AREF_V / SUPPLY_OHM
    thick, thin = (bracket_hz(0.04, 0.02, t, 0.02) for t in (0.003, 0.0015))
    preload_N = 2.0 / (0.2 * 0.004)
    found = {
        "drop in the sensor's supply": f"{1e3 * drop_v:.0f} mV",
        "of the supply": f"{100 * drop_v / AREF_V:.1f} %",
        "the gain, if the sensor's current changes by a fifth": f"{20 * drop_v / AREF_V:.1f} %",
        "a supply wire on ground": f"{1e3 * short_a:.0f} mA",
        "into 100 Ω": f"{short_a**2 * SUPPLY_OHM:.2f} W",
        "a signal wire on a car's battery": f"{1e3 * (BATTERY_V - 5.5) / INPUT_OHM:.1f} mA",
        "a neighbour that differs by 1 V": f"{input_error(1.0):.2f} code",
        "3 m of cable at the sensor's output": f"{100 * CABLE_F_PER_M * CABLE_M / OUTPUT_F:.2g} %",
        "a board's own regulator off by 1 %": f"{CODES / 2 * 0.01 / CODES_PER_G:.2f} g",
        "470 µF from 5.0 to 4.5 V at 60 mA": f"{470e-6 * 0.5 / 0.06 * 1e3:.1f} ms",
        "keeping a power bank awake, 47 Ω": f"{5 / 47 * 1e3:.0f} mA",
        "and its heat": f"{25 / 47:.2f} W",
        "safe at 16 MHz from": f"{2.7 + 1.8 * (16 - 10) / (20 - 10):.2f} V",
        "2000 mAh at 60 mA": f"{2000 / 60:.0f} h",
        "an hour, by a clock that is off by 0.3 %": f"{3600 * 0.003:.0f} s",
        "stiffness, by a clock that is off by 0.3 %": f"{100 * (1.003**2 - 1):.1f} %",
        "bracket of 3 mm": f"{thick:.0f} Hz",
        "bracket of 1.5 mm": f"{thin:.0f} Hz",
        "its error at 30 Hz, 3 mm": f"{100 / (1 - (BAND_HZ / thick) ** 2) - 100:.1f} %",
        "its error at 30 Hz, 1.5 mm": f"{100 / (1 - (BAND_HZ / thin) ** 2) - 100:.1f} %",
        "error at 30 Hz of a mount at 300 Hz": f"{100 * (BAND_HZ / 300) ** 2:.0f} %",
        "5° of tilt: gain": f"{100 * (1 - cos(radians(5))):.1f} %",
        "5° of tilt: of what is along": f"{100 * sin(radians(5)):.0f} %",
        "an M4 at 2 N·m": f"{preload_N:.0f} N",
        "20 g at 16 g": f"{0.02 * 16 * 9.81:.1f} N",
        "0.47 µF": f"{left_dB(LINE_HZ, 100, 1 / (2 * pi * OUTPUT_OHM * 0.47e-6)):.0f} dB",
        "its corner": f"{1 / (2 * pi * OUTPUT_OHM * 0.47e-6):.1f} Hz",
        "what undoing it does to rounding at 30 Hz": (
            f"{hypot(1, BAND_HZ * 2 * pi * OUTPUT_OHM * 0.47e-6):.1f} times"
        ),
    }
    for rate in (100, 200, 400):
        line, down = least_folded(rate)
        found[f"line that comes through best below 30 Hz, {rate}"] = f"{line:.0f} Hz"
        found[f"and how far it is down, {rate}"] = f"{down:.1f} dB"
        found[f"60 Hz, {rate}"] = line_left(rate)
    return found


def main() -> None:
    """Print them."""
    for name, value in numbers().items():
        print(f"{name:52}{value:>12}")


if __name__ == "__main__":
    main()
