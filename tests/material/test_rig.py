"""From signals of a rig that shares no code to moduli, loops and the end of linear theory."""

import numpy as np
import pytest

from tests.material.rig_signals import maxwell_force, sine_steps, sweep
from wheelhop.material import GeneralizedMaxwell, MaterialError, fit_modulus, read_rig_data
from wheelhop.material.rig import amplitude_effects, model_loop, modulus_data, points

TIMES = [0.1, 0.02, 0.003]
NUMBERS = np.array([5e5, 1e5, 2e5, 1e5])
MODEL = GeneralizedMaxwell(TIMES)
STEPS = np.array([1.0, 2.0, 5.0, 10.0, 20.0, 30.0])


def recorded(time, x, noise=0.0, seed=0):
    force = maxwell_force(time, x, NUMBERS[0], 0.0, NUMBERS[1:], TIMES)
    return force + np.random.default_rng(seed).normal(0.0, noise, len(x))


def test_sine_steps_give_the_modulus():
    time, x = sine_steps(STEPS, [5e-4])
    data = modulus_data("steps", points("steps", time, x + 0.01, recorded(time, x) - 3434.0))
    assert data.frequency_hz == pytest.approx(STEPS, rel=1e-3)
    exact = MODEL.modulus(data.omega, NUMBERS)
    assert np.abs(data.modulus / exact - 1).max() < 2e-3


def test_a_sweep_gives_the_modulus():
    time, x = sweep(1.0, 30.0, 60.0, 5e-4)
    data = modulus_data("sweep", points("sweep", time, x, recorded(time, x)))
    assert len(data.frequency_hz) > 15
    exact = MODEL.modulus(data.omega, NUMBERS)
    assert np.abs(data.modulus / exact - 1).max() < 5e-3


def test_the_uncertainty_is_the_scatter_of_what_is_found():
    """Twenty records with other noise scatter as each of them says."""
    time, x = sine_steps(STEPS[:3], [5e-4])
    force = recorded(time, x)
    noise = np.random.default_rng(1).normal(0.0, 10.0, (20, len(x)))
    drawn = [modulus_data("n", points("n", time, x, force + each)) for each in noise]
    scatter = np.std([d.modulus.real for d in drawn], axis=0, ddof=1)
    stated = np.mean([d.uncertainty for d in drawn], axis=0)
    assert ((scatter / stated > 0.6) & (scatter / stated < 1.6)).all()


def test_a_loop_is_the_measured_one():
    time, x = sine_steps([5.0], [5e-4])
    (point,) = points("loop", time, x, recorded(time, x))
    loop = model_loop(point.modulus, point.amplitude_m)
    area = 0.5 * abs(
        np.sum(loop[:-1, 0] * np.diff(loop[:, 1]) - loop[:-1, 1] * np.diff(loop[:, 0]))
    )
    assert area == pytest.approx(np.pi * point.modulus.imag * point.amplitude_m**2, rel=1e-3)
    measured = point.loop
    inner = np.interp(measured[:, 0], [-1e-3, 1e-3], [-1e-3, 1e-3]) * point.modulus.real
    width = point.modulus.imag * np.sqrt(np.maximum(point.amplitude_m**2 - measured[:, 0] ** 2, 0))
    assert (
        np.abs(np.abs(measured[:, 1] - inner) - width).max() < 0.02 * np.abs(measured[:, 1]).max()
    )


def test_where_linear_theory_ends():
    """A cubic spring hardens with amplitude: k + ¾ k₃ a², the describing function; a linear
    specimen does not change."""
    time, x = sine_steps([2.0, 10.0], [5e-4, 1e-3])
    linear = points("linear", time, x, recorded(time, x, 2.0))
    assert not any(effect.significant for effect in amplitude_effects(linear))
    third = 4e11
    cubic = points("cubic", time, x, recorded(time, x, 2.0) + third * x**3)
    for effect in amplitude_effects(cubic):
        exact = np.abs(
            MODEL.modulus(np.array([2 * np.pi * effect.frequency_hz]), NUMBERS)
            + 0.75 * third * np.array(effect.amplitudes_m) ** 2
        )
        assert effect.significant
        assert effect.per_doubling == pytest.approx(np.log(exact[1] / exact[0]), rel=0.02)
    assert modulus_data("cubic", cubic).modulus[0].real < cubic[2].modulus.real  # the smallest


def write(path, names, columns):
    rows = "\n".join(",".join(repr(float(v)) for v in row) for row in zip(*columns, strict=True))
    path.write_text(",".join(names) + "\n" + rows + "\n")
    return path


def test_a_file_of_signals_and_one_of_moduli_say_the_same(tmp_path):
    time, x = sine_steps(STEPS, [5e-4])
    names = ("time_s", "displacement_mm", "force_kN")
    found = read_rig_data(
        write(tmp_path / "s.csv", names, (time, 1e3 * x, recorded(time, x) / 1e3))
    )
    m = found.moduli
    names = ("frequency_hz", "dynamic_N_mm", "loss_N_mm")
    columns = (m.frequency_hz, m.modulus.real / 1e3, m.modulus.imag / 1e3)
    again = read_rig_data(write(tmp_path / "m.csv", names, columns)).moduli
    assert np.allclose(again.modulus, m.modulus)
    assert fit_modulus(MODEL, again).parameters == pytest.approx(NUMBERS, rel=0.1)


F = [1.0, 2.0, 5.0, 10.0]
D = [900.0, 920.0, 950.0, 980.0]
L = [80.0, 85.0, 90.0, 95.0]
GOOD = ("frequency_hz", "dynamic_N_mm", "loss_N_mm")
BAD = {
    "one frequency": (GOOD, (F[:1], D[:1], L[:1]), "one frequency"),
    "three": (GOOD, (F[:3], D[:3], L[:3]), "3 frequencies"),
    "negative loss": (GOOD, (F, D, [80.0, -1.0, 90.0, 95.0]), "loss modulus is -1.*2 Hz"),
    "negative stiffness": (GOOD, (F, [-900.0, *D[1:]], L), "opposite directions"),
    "NaN": (GOOD, (F, D, [80.0, float("nan"), 90.0, 95.0]), "line 3.*nan"),
    "twice": (GOOD, ([1.0, 2.0, 2.0, 3.0], D, L), "2 Hz comes twice"),
    "mixed units": (("frequency_hz", "dynamic_N_mm", "loss_N_m"), (F, D, L), "different units"),
    "no unit": (("frequency_hz", "dynamic", "loss"), (F, D, L), "unit of dynamic"),
    "no loss": (("frequency_hz", "dynamic_N_mm"), (F, D), "no column loss_"),
    "zero frequency": (GOOD, ([0.0, *F[1:]], D, L), "frequencies are positive"),
    "extra": ((*GOOD, "phase_deg"), (F, D, L, L), "unexpected column phase_deg"),
    "neither": (("f", "d"), (F, D), "no column frequency_hz or time_s"),
    "still": (("time_s", "displacement_mm", "force_N"), (F, F, F), "no 4 whole cycles"),
    "backwards": (("time_s", "displacement_mm", "force_N"), (F[::-1], F, F), "does not rise"),
}


@pytest.mark.parametrize("names, columns, says", BAD.values(), ids=BAD)
def test_bad_input_is_one_line_that_names_the_file(tmp_path, names, columns, says):
    from wheelhop.files import InputError

    with pytest.raises(InputError, match=says) as caught:
        read_rig_data(write(tmp_path / "bad.csv", names, columns))
    assert "bad.csv" in str(caught.value) and "\n" not in str(caught.value)
    assert isinstance(caught.value, MaterialError) or says.startswith(("no 4", "does"))
