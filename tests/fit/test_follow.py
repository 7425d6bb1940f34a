"""What a run leaves free follows the numbers it is told against."""

from dataclasses import replace

import numpy as np

from tests import truth
from tests.simulate.setup import ATV, EFFECTS, campaign_of, model_of, relative, simulated
from wheelhop.fit import Workshop, effect_parameters, fit, follow

FREQ = "engine-vibration.freq_hz"


def test_an_engines_speed_in_a_run_follows_the_mean_of_all_runs():
    """A mean speed 1 % higher and the run's own share 1 % lower are the same engine; alone, the
    first is a turn and more of phase at the record's ends."""
    track = truth.Track("washboard", {"amplitude_mm": 5.0, "pitch_mm": 600.0})
    runs = {"held": truth.Run(track, 3.4, 36.2, np.arange(1024) / 100.0)}
    engine = {"cos_m_s2": 1.3, "sin_m_s2": 0.0, "excess": 0.02}
    true = model_of(ATV, runs, "engine-vibration", {"freq_hz": 14.0}, own=engine)
    clean = simulated(campaign_of(runs), true)
    workshop = Workshop(campaign_of(runs, clean, noise_rms=0.1), true)
    effect = EFFECTS["engine-vibration"]
    shared = effect_parameters(workshop.parameters_of(effect), true, effect)
    fitted = fit(workshop, true, shared, workshop.of_role("fit"))
    moved = replace(
        fitted, model=fitted.model.with_values({FREQ: 1.01 * fitted.model.values[FREQ]})
    )

    followed = follow(workshop, fitted.model, moved, workshop.of_role("fit"))
    assert followed.values == moved.model.values
    campaign = workshop.campaign
    assert relative(simulated(campaign, moved.model)["held"], clean["held"]) > 0.3
    assert relative(simulated(campaign, followed)["held"], clean["held"]) < 0.03
