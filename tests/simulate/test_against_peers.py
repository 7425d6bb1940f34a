"""The same car for MuJoCo and Exudyn, and none of wheelhop's code: same accelerations."""

import mujoco
import pytest

pytest.importorskip("exudyn")

from benchmarks import exudyn_car, peers
from benchmarks.peers_model import flexible, with_laws

STEP_S = peers.EVERY_S / 16
SPEED_M_S = 3.0
REACHED = 0.003
"""They are 4e-4 apart where all converge; 0.01 is asked."""


@pytest.mark.parametrize("make", [flexible, with_laws])
def test_mujoco_and_exudyn_go_over_the_bump_as_we_do(make):
    mechanism = make()
    wanted = peers.ours(mechanism.system, (SPEED_M_S,), STEP_S)
    car = peers.MujocoCar(mechanism, mujoco.mjtIntegrator.mjINT_RK4)
    in_mujoco = car.run(SPEED_M_S, STEP_S)()
    other = exudyn_car.Car(mechanism, SPEED_M_S, peers.EVERY_S)
    in_exudyn = other.run(peers.SECONDS + peers.EVERY_S, STEP_S, exudyn_car.EXPLICIT)
    for velocity in (in_mujoco, in_exudyn):
        assert peers.off([peers.averaged(velocity, mechanism.output)], wanted) < REACHED
