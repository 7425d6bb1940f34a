"""Axle to body: what the identified matrix predicts of every run, beside its record."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from wheelhop.campaign import read_campaign
from wheelhop.files.words import percent
from wheelhop.identify import Linearity, candidate, measure, predict, suspensions
from wheelhop.identify.structure import Structure
from wheelhop.vehicle import read_nominal
from wheelhop.workbench import show, worker
from wheelhop.workbench.shown import AxleToBody
from wheelhop.workbench.worker import Work, Worker


@pytest.fixture
def identified(small):
    campaign = read_campaign(small)
    vehicle, measured = read_nominal(campaign), measure(campaign)
    belief = suspensions(vehicle.values, vehicle.uncertainty)
    return campaign, candidate(measured, Structure(), 4, belief).model, measured


def test_every_run_stands_beside_what_is_predicted_of_it(identified, monkeypatch):
    campaign, model, measured = identified
    said = Linearity("cannot tell", "?", 4, 0.1, 1.0, 1.0, None, 0.0, np.ones(4), (), model)
    monkeypatch.setattr(worker, "linearity", lambda *_: said)
    monkeypatch.setattr(show, "axle_to_body", lambda *_: "")  # takes a fitted baseline
    heard = []
    work = Work(campaign, None, SimpleNamespace(campaign=campaign), {}, None)
    Worker(heard.append)._identify(work, ())
    (found,) = [message for message in heard if isinstance(message, AxleToBody)]
    summaries = re.findall(r"<summary>(.*?)</summary>", found.html)
    assert len(summaries) == len(campaign.runs) == found.html.count("</details>")
    for one in predict(model, measured):
        (line,) = [text for text in summaries if text.startswith(f"{one.run}, ")]
        assert ("held out" in line) == one.held_out
        left = np.sum(np.abs(one.measured - one.predicted) ** 2)
        overall = np.sqrt(left / np.sum(np.abs(one.measured) ** 2))
        assert percent(float(overall), 2) in line
