"""The functional mock-up unit, run by FMPy, against wheelhop's own integrator."""

import shutil

import numpy as np
import pytest

from tests.export.cars import FOLDER, ROUGH, ground, model, ours
from wheelhop.cli.main import main
from wheelhop.export.c_laws import in_c
from wheelhop.export.fmu import unit_of, write_fmu
from wheelhop.export.plant import plant_of

fmpy = pytest.importorskip("fmpy")
from fmpy.fmi2 import FMU2Slave  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402

STEP_S = 0.000625
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


class Unit:
    """A unit that FMPy has loaded, at the beginning of its time."""

    def __init__(self, file, folder):
        self.about = fmpy.read_model_description(str(file))
        self.number = {v.name: v.valueReference for v in self.about.modelVariables}
        self.slave = FMU2Slave(
            guid=self.about.guid,
            unzipDirectory=fmpy.extract(str(file), unzipdir=str(folder)),
            modelIdentifier=self.about.coSimulation.modelIdentifier,
            instanceName="car",
        )
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()

    def set(self, names, values):
        self.slave.setReal([self.number[name] for name in names], list(map(float, values)))

    def get(self, names):
        return self.slave.getReal([self.number[name] for name in names])


@pytest.fixture(scope="module")
def rough(tmp_path_factory):
    """A car with friction, stops, tyres that lift off and a seat: plant and unit."""
    plant = plant_of(model(ROUGH))
    file = tmp_path_factory.mktemp("fmu") / "car.fmu"
    assert write_fmu(plant, STEP_S, 'car <of> "ours"', file)
    return plant, file


def signals(plant, what):
    return [f"ground_{corner + 1}_{what}" for corner in plant.corners]


def driven(unit, plant, step_s, steps, *, exactly):
    """Outputs at the steps 1 … steps − 1; `exactly`: told how heights bend within a step, such as
    our integrator takes them: a cubic through heights and rates at both ends."""
    time_s = step_s * np.arange(steps + 1)
    height, rate = ground(time_s, plant.corners)[:2]
    rates = [unit.number[name] for name in signals(plant, "rate_m_s")]
    found = np.empty((steps - 1, len(plant.outputs)))
    for k in range(steps):
        unit.set(signals(plant, "height_m"), height[k])
        unit.set(signals(plant, "rate_m_s"), rate[k])
        if k == 0:
            unit.slave.exitInitializationMode()
        else:
            found[k - 1] = unit.get(plant.outputs)
        if exactly:
            rise = (height[k + 1] - height[k]) / step_s
            second = (6 * rise - 4 * rate[k] - 2 * rate[k + 1]) / step_s
            third = (6 * rate[k] + 6 * rate[k + 1] - 12 * rise) / step_s**2
            for order, values in ((1, second), (2, third)):
                unit.slave.setRealInputDerivatives(rates, [order] * len(rates), values.tolist())
        unit.slave.doStep(k * step_s, step_s)
    return found


def off(found, truth):
    """Largest difference of each output over its largest value."""
    return np.abs(found - truth).max(axis=0) / np.abs(truth).max(axis=0)


def test_the_unit_is_valid(rough):
    assert validate_fmu(str(rough[1])) == []


def test_on_the_same_ground_it_is_our_simulation(rough, tmp_path):
    plant, file = rough
    steps = 2400
    _, truth = ours(plant, STEP_S, steps)
    tyre = truth[:, plant.outputs.index("tyre_1_force_N")]
    travel = truth[:, plant.outputs.index("strut_1_travel_m")]
    assert tyre.min() < -500.0 and np.abs(travel).max() > 0.02, "it lifts off, and strikes a stop"
    found = driven(Unit(file, tmp_path), plant, STEP_S, steps, exactly=True)
    assert off(found, truth).max() < 1e-9


def test_a_tool_that_knows_nothing_of_derivatives_comes_as_close(rough, tmp_path):
    """At steps of 0.1 ms the unit finds by itself how the ground goes on, but for the first two."""
    plant, file = rough
    step_s, steps = 1e-4, 6000
    _, truth = ours(plant, step_s, steps)
    found = driven(Unit(file, tmp_path), plant, step_s, steps, exactly=False)
    displaced = [i for i, name in enumerate(plant.outputs) if name.endswith("_m")]
    assert off(found, truth)[displaced].max() < 1e-6


def test_fmpy_runs_it_with_its_own_loop(rough):
    plant, file = rough
    time_s = np.arange(0.0, 0.5, 1e-3)
    height, rate = ground(time_s, plant.corners)[:2]
    names = [*signals(plant, "height_m"), *signals(plant, "rate_m_s")]
    rows = np.column_stack([time_s, height, rate])
    table = np.array(
        [tuple(row) for row in rows], dtype=[("time", float), *((n, float) for n in names)]
    )
    result = fmpy.simulate_fmu(
        str(file), stop_time=0.45, step_size=1e-3, output_interval=1e-3, input=table,
        output=["strut_1_travel_m"],
    )  # fmt: skip
    _, truth = ours(plant, 1e-3 / 2, 900)
    travel = truth[1::2, plant.outputs.index("strut_1_travel_m")]
    shown = np.interp(1e-3 * np.arange(1, 440), result["time"], result["strut_1_travel_m"])
    assert shown == pytest.approx(travel[:439], abs=2e-3 * np.abs(travel).max())


def test_a_state_that_was_kept_is_gone_back_to(rough, tmp_path):
    plant, file = rough
    unit = Unit(file, tmp_path)
    driven(unit, plant, STEP_S, 40, exactly=False)
    state = unit.slave.getFMUState()
    told = []
    for _ in range(2):
        for k in range(40, 60):
            unit.slave.doStep(k * STEP_S, STEP_S)
        told.append(unit.get(plant.outputs))
        unit.slave.setFMUState(state)
    unit.slave.freeFMUState(state)
    assert told[0] == told[1]


def test_actuators_push_body_and_axles_apart(tmp_path):
    """On still ground: springs stretch until they hold the actuators, and tyres carry no more."""
    linear = model(())
    plant = plant_of(linear)
    write_fmu(plant, STEP_S, "car", tmp_path / "car.fmu")
    unit = Unit(tmp_path / "car.fmu", tmp_path / "unit")
    unit.set([f"actuator_{i}_force_N" for i in (1, 2, 3, 4)], 4 * [100.0])
    unit.slave.exitInitializationMode()
    for k in range(2000):
        unit.slave.doStep(k * 0.01, 0.01)
    for corner, end in ((1, "front"), (3, "rear")):
        travel, force = unit.get([f"strut_{corner}_travel_m", f"tyre_{corner}_force_N"])
        rate = linear.values[f"suspension.{end}.stiffness_N_m"]
        assert travel == pytest.approx(100.0 / rate, rel=1e-6)
        assert force == pytest.approx(0.0, abs=1e-4)


def test_signals_say_their_units(rough):
    plant, file = rough
    about = fmpy.read_model_description(str(file))
    units = {v.name: v.unit for v in about.modelVariables}
    assert set(units) == {*plant.inputs, *plant.outputs}
    assert units["B1_acceleration_m_s2"] == "m/s2" and units["ground_1_rate_m_s"] == "m/s"
    assert units["tyre_1_force_N"] == "N" and units["body_roll_rad"] == "rad"
    assert all(units[name] == unit_of(name) for name in units)


def every_law():
    """Each law of the library, by its name, from a car or a component that has all effects."""
    from wheelhop.effects import (
        asymmetric_damper,
        backlash,
        bump_stop,
        digressive_damper,
        dry_friction,
        hysteresis,
        mount_bushing,
        progressive_spring,
        progressive_tyre,
        quadratic_damper,
        tyre_lift_off,
    )  # fmt: skip
    from wheelhop.tune import damper_curve

    rooms = (
        asymmetric_damper, backlash, bump_stop, digressive_damper, dry_friction, hysteresis,
        mount_bushing, progressive_spring, progressive_tyre, quadratic_damper, tyre_lift_off,
        damper_curve,
    )  # fmt: skip
    found = {}
    for room in rooms:
        for name, value in vars(room).items():
            arguments = getattr(getattr(value, "py_func", None), "__code__", None)
            if arguments and arguments.co_varnames[:6] == ("x", "v", "dx", "dt", "z", "p"):
                found[name] = value
    return found


NUMBERS = {
    "free_play": (0.004, 2e4, 600.0, 900.0, 1e-4),
    "interpolated": (3.0, -0.5, 0.0, 0.6, -90.0, 5.0, 250.0),
    "in_series": (2e-6, 0.01, 2e4, 600.0),
    "relaxing": (3e4, 40.0, 100.0, 10.0),
    "bristles": (60.0, 3e5, 1.4, 0.02),
    "bouc_wen": (60.0, 5e-4, 0.7),
    "yielding": (60.0, 5e-4, 0.03),
    "slip_behind_play": (60.0, 3e5, 0.001),
    "elastic_slip": (60.0, 3e5),
    "creeping_slip": (60.0, 0.01),
    "stops": (5e4, 0.01, 0.02),
    "gas": (700.0, 4.0, 1.3),
    "no_pull": (4e4, 200.0, 900.0, 1.0, 3.0, 5.0),
}


@pytest.mark.parametrize("name", every_law())
def test_every_law_is_the_same_in_c(name, tmp_path):
    """Called side by side from C and Python along a motion that turns, memory included."""
    import ctypes
    import subprocess

    one = every_law()[name]
    source = (
        "#include <math.h>\n"
        + in_c([one])
        + (
            "\ndouble called(double x, double v, double dx, double dt, double z, const double *p,"
            " double *after) { return law_0(x, v, dx, dt, z, p, after); }\n"
        )
    )
    (tmp_path / "law.c").write_text(source)
    words = ["cc", "-std=c99", "-Wall", "-Werror", "-Wno-unused", "-O2", "-fPIC", "-shared"]
    subprocess.run([*words, "law.c", "-o", "law.so", "-lm"], cwd=tmp_path, check=True)
    called = ctypes.CDLL(str(tmp_path / "law.so")).called
    called.restype = ctypes.c_double
    numbers = np.zeros(8)
    given = NUMBERS.get(name, (500.0, 0.3, 2.0))
    numbers[: len(given)] = given
    p = numbers.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
    after, z, before, dt = ctypes.c_double(), 0.0, 0.0, 0.000625
    worst, largest = 0.0, 0.0
    for k in range(600):
        t = k * dt
        x, v = 0.03 * np.sin(40 * t) * np.exp(-t), 1.2 * np.cos(40 * t)
        arguments = [ctypes.c_double(float(a)) for a in (x, v, x - before, dt, z)]
        force = called(*arguments, p, ctypes.byref(after))
        truth, memory = one(float(x), float(v), float(x - before), dt, z, numbers)
        worst = max(worst, abs(force - truth), abs(after.value - memory))
        largest, z, before = max(largest, abs(truth)), memory, x
    assert largest > 0.0 and worst <= 1e-9 * max(largest, 1.0)


def test_the_command_writes_a_unit_and_a_file_for_matlab(tmp_path, capsys):
    vehicle = str(tmp_path / "v.toml")
    shutil.copy(FOLDER / "clean/vehicle.toml", vehicle)
    assert main(["export", vehicle, str(tmp_path / "car.fmu")]) == 0
    assert validate_fmu(str(tmp_path / "car.fmu")) == []
    assert main(["export", vehicle, str(tmp_path / "car.mat"), "--with", "dry-friction"]) == 0
    assert main(["export", vehicle, str(tmp_path / "car.txt")]) == 2
    assert ".fmu" in capsys.readouterr().err
