"""One diagnosis with an effect to find and one without, shared by the tests of the reports."""

import pytest

from tests.report.small import write_small_campaign
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import climb, fit_baseline
from wheelhop.effects import load_effects
from wheelhop.vehicle import read_vehicle

LIBRARY = {
    name: load_effects()[name] for name in ("dry-friction", "asymmetric-damper", "sensor-gain")
}


class Case:
    """A campaign with its vehicle and its diagnosis."""

    def __init__(self, folder, library):
        self.library = library
        self.campaign = read_campaign(folder)
        self.vehicle = read_vehicle(self.campaign.vehicle_file)
        base = fit_baseline(self.campaign, self.vehicle, progress=lambda text: None)
        self.diagnosis = climb(base, library, max_effects=1, progress=lambda text: None)


@pytest.fixture(scope="session")
def friction(tmp_path_factory):
    return Case(write_small_campaign(tmp_path_factory.mktemp("friction") / "c"), LIBRARY)


@pytest.fixture(scope="session")
def clean(tmp_path_factory):
    folder = write_small_campaign(tmp_path_factory.mktemp("clean") / "c", "clean")
    return Case(folder, {"dry-friction": LIBRARY["dry-friction"]})
