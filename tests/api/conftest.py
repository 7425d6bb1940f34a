"""One comparison and one diagnosis of a small part of an example, for all tests of this package."""

import pytest

import wheelhop as wh
from tests.report.small import write_small_campaign


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    return write_small_campaign(tmp_path_factory.mktemp("api") / "c")


@pytest.fixture(scope="session")
def campaign(folder):
    return wh.read(folder)


@pytest.fixture(scope="session")
def fitted(campaign):
    return wh.compare(campaign, "dry-friction")


@pytest.fixture(scope="session")
def found(campaign):
    library = wh.load_effects()
    few = {name: library[name] for name in ("dry-friction", "bump-stop", "asymmetric-damper")}
    return wh.diagnose(campaign, effects=few, max_effects=1)
