"""A diagnosis says whether what is missing between axle and body is linear."""

from pathlib import Path

import numpy as np
import pytest

from tests.report.small import write_small_campaign
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import diagnose, to_json
from wheelhop.report.reports import write_diagnosis_report
from wheelhop.vehicle import read_vehicle

EXAMPLES = Path(__file__).parents[2] / "examples"


SEAT = pytest.param("open-driver-seat", marks=pytest.mark.slow)  # half a minute


@pytest.fixture(scope="module", params=[SEAT, "open-dry-friction"])
def diagnosed(request):
    """With nothing to try, not even that a sensor sits elsewhere: the answer stands on the records
    alone."""
    campaign = read_campaign(EXAMPLES / request.param)
    vehicle = read_vehicle(campaign.vehicle_file)
    return request.param, campaign, diagnose(campaign, vehicle, {}, max_effects=0, jobs=1)


def test_a_seat_is_missing_and_linear_friction_is_missing_and_not(diagnosed):
    """A seat hangs from the body by a spring and a damper: all it does is linear, and the same
    share of the motion is left at every level but for noise. Friction is a force of one size: its
    share grows as the motion becomes small."""
    name, campaign, diagnosis = diagnosed
    found = to_json(diagnosis)["axle_to_body"]
    assert diagnosis.verdict == ("unknown",)
    assert found["answer"] == {"open-driver-seat": "linear"}.get(name, "not linear")
    assert {row["run"] for row in found["levels"]} == {r.id for r in campaign.validate_runs}
    level, left = np.array([(row["rms_m_s2"], row["error"]) for row in found["levels"]]).T
    if found["answer"] == "linear":
        assert found["law"] is None
        assert min(found["coherence"]) > 0.999
        # A constant of noise, in m/s², is all that is left: twice noise, not more, at any level.
        assert (left * level).max() < 3 * campaign.noise_rms
    else:
        assert (found["law"], max(found["coherence"]) < 0.999) == ("friction", True)
        assert left[np.argmin(level)] > 2 * left[np.argmax(level)]


def test_the_report_shows_the_answer_and_each_level(diagnosed, tmp_path):
    _, campaign, diagnosis = diagnosed
    write_diagnosis_report(tmp_path / "r.html", campaign, diagnosis, {})
    page = (tmp_path / "r.html").read_text()
    part = page[page.index("Linear between axle and body?") :].split("</section>")[0]
    assert diagnosis.axle_to_body.sentence.split(":")[0] in part
    assert all(run.id in part for run in campaign.validate_runs)
    assert "identified and modelled transfer functions" in part  # the picture
    assert all(f"A{j} → B{i}" in part for i in range(1, 5) for j in range(1, 5))


def test_where_nothing_is_missing_it_is_not_asked(tmp_path):
    campaign = read_campaign(write_small_campaign(tmp_path / "c", "clean"))
    diagnosis = diagnose(campaign, read_vehicle(campaign.vehicle_file), {}, jobs=1)
    assert diagnosis.verdict == ("none",)
    assert to_json(diagnosis)["axle_to_body"] is None
    write_diagnosis_report(tmp_path / "r.html", campaign, diagnosis, {})
    assert "Linear between axle and body?" not in (tmp_path / "r.html").read_text()
