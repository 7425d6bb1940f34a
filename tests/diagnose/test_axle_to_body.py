"""A diagnosis says whether what is missing between axle and body is linear."""

import pytest

from tests.report.small import write_small_campaign
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import diagnose, to_json
from wheelhop.effects import load_effects
from wheelhop.report import write_diagnosis_report
from wheelhop.vehicle import read_vehicle


@pytest.mark.parametrize(
    ("example", "answers"),
    [("open-dry-friction", {"not linear", "cannot tell"}), ("clean", {None})],
)
def test_the_answer_stands_in_json_and_report(tmp_path, example, answers):
    campaign = read_campaign(write_small_campaign(tmp_path / "c", example))
    effects = {name: load_effects()[name] for name in ("dry-friction", "driver-seat")}
    diagnosis = diagnose(campaign, read_vehicle(campaign.vehicle_file), effects, jobs=1)
    found = to_json(diagnosis)["axle_to_body"]
    assert (found and found["answer"]) in answers
    write_diagnosis_report(tmp_path / "r.html", campaign, diagnosis, effects)
    page = (tmp_path / "r.html").read_text()
    assert ("Linear between axle and body?" in page) == (found is not None)
