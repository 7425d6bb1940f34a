"""Axles that move fore and aft as inputs, too: eight of them (thesis chapter 6, future work)."""

import json

import numpy as np
import pytest

from tests.identify.test_legs import OLD, rigid_car
from tests.report.small import write_small_campaign
from wheelhop.campaign import AXLE_POINTS, BODY_POINTS, CampaignError, read_campaign
from wheelhop.cli.main import main
from wheelhop.identify import Structure, Suspensions, identify, judge, measure, other_suspensions
from wheelhop.identify.spectra import spectra
from wheelhop.identify.statespace import StateSpace
from wheelhop.identify.structure import RIGID
from wheelhop.identify.synthetic import BAND_HZ, RATE_HZ, records

EIGHT = tuple(range(8))
ARMS_N_M = np.diag([9e3, 9e3, -6e3, -6e3])
"""Upward force on the body of an inclined arm, per way of its axle ahead of the body."""
FORWARD = np.eye(4) - 0.25
"""The body goes forward with its axles' mean: what is left of their way bends the arms."""


def truth():
    """A rigid body on struts, and on arms that lift where an axle is pushed back."""
    body = rigid_car().body
    h = other_suspensions(body, OLD, OLD)
    b = np.hstack([h.b, body.b @ ARMS_N_M @ FORWARD])
    return StateSpace(h.a, b, h.c, np.hstack([h.d, np.zeros((4, 4))]))


@pytest.fixture(scope="module")
def runs():
    inputs, outputs = records(truth(), 0.02, runs=16, samples=512, seed=5)
    return spectra(inputs, outputs, RATE_HZ, BAND_HZ), 0.02 * outputs.std()


def fitted(runs, inputs):
    ratio, times = OLD.rear_N_m / OLD.front_N_m, OLD.damping / OLD.stiffness
    belief = Suspensions(np.array([ratio, times[0], times[2]]), np.full(3, 1e-3))
    part = runs.only(np.arange(12))
    part = type(part)(part.runs, part.omega, part.inputs[:, :, inputs], part.outputs, part.samples)
    return identify([part], Structure(), order=6, inputs=tuple(inputs), suspensions=belief)


def left(runs, h, inputs):
    held = runs.only(np.arange(12, 16))
    held = type(held)(held.runs, held.omega, held.inputs[:, :, inputs], held.outputs, held.samples)
    return judge(h, [held], None).error


def test_eight_inputs_leave_noise_where_four_leave_the_arms(runs):
    made, _ = runs
    eight, four = (fitted(made, list(range(count))) for count in (8, 4))
    assert left(made, eight, list(range(8))) < 1.1 * 0.02
    assert left(made, four, list(range(4))) > 0.1
    # The poles are the body's all the same.
    true = np.sort(np.abs([p for p in truth().poles() if p.imag > 0])) / (2 * np.pi)
    for (frequency, error, *_), hertz in zip(sorted(eight.poles_table()), true, strict=True):
        assert abs(frequency - hertz) < 3.5 * error < 0.1 * hertz


def test_axles_moved_alike_carry_the_body_along_and_do_not_lift_it(runs):
    h = fitted(runs[0], list(range(8)))(0.0)[0].real
    assert h[:, :4] @ RIGID == pytest.approx(RIGID, abs=1e-6)
    assert h[:, 4:] @ np.ones(4) == pytest.approx(np.zeros(4), abs=1e-6)
    assert h[:, 4:] == pytest.approx(truth()(0.0)[0].real[:, 4:], abs=0.1)
    # Mirrored left and right; not symmetric, for a way forward is no force up.
    swap = [1, 0, 3, 2]
    assert h[swap][:, [*swap, 5, 4, 7, 6]] == pytest.approx(h)


def test_a_campaign_with_channels_along_x(tmp_path):
    folder = write_small_campaign(tmp_path / "car", "clean")
    file = folder / "campaign.toml"
    with pytest.raises(CampaignError, match="along x"):
        measure(read_campaign(folder), fore_aft=True)
    lines = ["[channels]", *(f'{p} = "{p}"' for p in (*AXLE_POINTS, *BODY_POINTS))]
    for point in AXLE_POINTS:
        about = f'quantity = "acceleration", axis = "x", position = "{point}"'
        lines.append(f"{point}_x = {{ {about} }}")
    head, runs = file.read_text().split("[[run]]", 1)
    file.write_text(head + "\n".join(lines) + "\n\n[[run]]" + runs)
    rng = np.random.default_rng(1)
    for path in (folder / "runs").glob("*.csv"):
        head, *rows = path.read_text().splitlines()
        added = rng.normal(size=(len(rows), 4))
        more = [
            ",".join([row, *(f"{a:.4f}" for a in four)])
            for row, four in zip(rows, added, strict=True)
        ]
        path.write_text("\n".join([head + ",A1_x,A2_x,A3_x,A4_x", *more]) + "\n")
    out = ["--json", str(tmp_path / "h.json")]
    assert main(["identify", str(folder), "--fore-aft", "--order", "4", *out]) == 0
    found = json.loads((tmp_path / "h.json").read_text())
    assert found["inputs"] == [*AXLE_POINTS, *(f"{point} x" for point in AXLE_POINTS)]
