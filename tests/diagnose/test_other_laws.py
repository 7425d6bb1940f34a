"""Machines of other laws than the library's: what it calls by the same name still wins.

The rivals are the effects of the same place, which are the ones that resemble them.
"""

import pytest

from tests.diagnose.cases import LIBRARY, diagnosed, oracle_of
from tests.truth import PRESETS, make_effect
from tests.truth.campaign import write_campaign

MACHINES = {
    "dry-friction": {"tanh_front_N": 0.0, "tanh_rear_N": 70.0, "creep_m_s": 0.005},
    "sensor-mount": {"channel": "B2", "freq_hz": 24.5, "zeta": 0.05, "struck_m_s": 0.1},
    "engine-vibration": {
        "force_N": 120.0,
        "freq_hz": 11.0,
        "run_spread_hz": 0.5,
        "wander_hz": 0.16,
        "x_m": -0.45,
    },
}


@pytest.mark.parametrize("name", MACHINES)
def test_a_machine_is_called_by_its_name(name, tmp_path):
    hidden = make_effect(name, MACHINES[name])
    write_campaign(tmp_path, PRESETS["atv"], [hidden], seed=101, short=True)
    rivals = {k: e for k, e in LIBRARY.items() if e.place == LIBRARY[name].place}
    diagnosis = diagnosed(tmp_path, rivals)
    assert diagnosis.verdict == (name,)
    assert diagnosis.confidence > 0.9
    oracle = oracle_of(tmp_path / "truth.toml")
    assert diagnosis.ladder[-1].rung.error_validate <= 1.05 * oracle
