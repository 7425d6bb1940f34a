"""A diagnosis is kept by what it was made of: whoever comes back to that finds it again."""

import asyncio
import re
import shutil
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.workbench.conftest import workbench
from wheelhop.campaign import read_campaign
from wheelhop.campaign.low_pass import LowPass
from wheelhop.files import Source
from wheelhop.workbench.desk import Desk
from wheelhop.workbench.results import Results
from wheelhop.workbench.session import Choice, made_of, read_session
from wheelhop.workbench.shown import (
    AxleToBody,
    Concluded,
    Done,
    Found,
    Law,
    Ranking,
    Refused,
    Row,
    Trace,
    Verdict,
)

EXAMPLES = Path(__file__).parents[2] / "examples"
HEADLINE = "Something is missing: bump-stop"
VERDICT = Verdict(("bump-stop",), 0.9, HEADLINE, ("It is.",), "")
FINDINGS = (Found("warning", "The speed of one run is off. Measure it."),)
BEFORE_SEVERAL = f"""\
format = 1
added = []

[diagnosis]
effects = ["bump-stop"]
confidence = 0.9
headline = "{HEADLINE}"
explanation = ["It is."]

[[ranking]]
effect = "bump-stop"
place = "suspension"
screened = 0.2
"""
"""A session.toml of a wheelhop that kept one diagnosis, of the choice beside it."""


def row(effect, confirmed=None):
    return Row(effect, "suspension", 0.2, confirmed, None, None, None, (), "")


def ranking(*rows, traces=(), beside=()):
    drawn = {name: Trace("run", "A1", "m/s²", *([0.0, 1.0] for _ in range(3))) for name in traces}
    return Ranking(beside, rows, drawn)


HALF = ranking(row("bump-stop"), row("backlash"), traces=["bump-stop"])
WHOLE = ranking(row("bump-stop", 0.1), row("backlash", 0.3))
HERE, THERE = ("here", ()), ("there", ())


def heard(results, made, *messages):
    for message in messages:
        results = results.heard(made, message)
    return results


def test_a_diagnosis_is_found_again_where_it_was_made():
    found = heard(Results(), HERE, HALF, WHOLE, Concluded(VERDICT, FINDINGS)).stopped()
    assert found.diagnosis(HERE).verdict == VERDICT
    assert found.diagnosis(HERE).findings == FINDINGS
    assert found.ranking(HERE).rows == WHOLE.rows
    assert found.ranking(HERE).traces == HALF.traces  # a signature comes once
    assert found.diagnosis(THERE) is None and found.ranking(THERE) is None
    assert found.diagnosis(("here", ("bump-stop",))) == found.diagnosis(HERE)
    opened_again = Results(found.diagnoses)
    assert opened_again.ranking(HERE).rows == WHOLE.rows


def test_who_stops_keeps_what_was_found_before_and_since():
    assert heard(Results(), HERE, HALF).stopped().ranking(HERE).rows == HALF.rows
    ended = heard(Results(), HERE, WHOLE, Concluded(VERDICT, ())).stopped()
    again = heard(Results(ended.diagnoses), HERE, HALF)
    assert again.ranking(HERE).rows == HALF.rows  # it fills in
    assert again.stopped().ranking(HERE).rows == WHOLE.rows
    assert again.stopped().ranking(HERE).traces == HALF.traces
    further = heard(heard(Results(), HERE, WHOLE).stopped(), HERE, HALF).stopped()
    assert further.ranking(HERE).rows == WHOLE.rows  # neither ended: the one that got further
    assert ended.stopped().ranking(HERE).rows == WHOLE.rows  # nothing was under way


def test_a_ranking_beside_accepted_effects_is_not_that_of_the_baseline():
    found = heard(Results(), HERE, WHOLE, ranking(row("backlash"), beside=("bump-stop",)))
    assert found.ranking(HERE).rows == WHOLE.rows


def test_a_law_stays_beside_the_model_it_was_found_beside():
    law, between = Law(("F = 3 v",), ""), AxleToBody("<p>linear</p>")
    found = heard(Results(), HERE, law, between)
    assert (found.beside(Law, HERE), found.beside(AxleToBody, HERE)) == (law, between)
    assert found.beside(Law, ("here", ("bump-stop",))) is None


# What a diagnosis is made of.


@pytest.fixture
def campaign(tmp_path):
    copy = shutil.copytree(EXAMPLES / "clean", tmp_path / "campaign")
    return read_campaign(copy)


def test_the_same_data_have_one_key(campaign, tmp_path):
    first, second = (run.id for run in campaign.runs[:2])
    key = made_of(campaign, Choice())
    assert made_of(campaign, Choice(added=("bump-stop",))) == key
    assert made_of(campaign, Choice(roles={first: campaign.runs[0].role})) == key
    both = made_of(campaign, Choice(without_runs=(first, second)))
    assert made_of(campaign, Choice(without_runs=(second, first))) == both != key
    moved = campaign.folder.rename(tmp_path / "elsewhere")
    assert made_of(read_campaign(moved), Choice()) == key


@pytest.mark.parametrize(
    "choice",
    [
        lambda c: Choice(without_runs=(c.runs[0].id,)),
        lambda c: Choice(without_channels=(c.channels[0].name,)),
        lambda c: Choice(roles={next(r.id for r in c.runs if r.role == "fit"): "validate"}),
    ],
)
def test_other_data_have_another_key(campaign, choice):
    assert made_of(campaign, choice(campaign)) != made_of(campaign, Choice())


def test_another_recorder_has_another_key(campaign):
    filters = (LowPass("butterworth", order, 60.0) for order in (2, 4))
    stated = [replace(campaign, low_pass=low_pass) for low_pass in filters]
    stated += [campaign, replace(campaign, averaging_s=0.5 * campaign.averaging_s)]
    assert len({made_of(one, Choice()) for one in stated}) == 4


def test_other_files_have_another_key(campaign):
    keys = {made_of(campaign, Choice())}
    effects = campaign.folder / "my_effects.py"
    for file in (
        campaign.runs[0].file,
        campaign.vehicle_file,
        campaign.folder / "calibration.toml",
    ):
        file.write_text((file.read_text() if file.is_file() else "") + "\n")
        keys.add(made_of(campaign, Choice()))
    for text in ("one", "other"):
        keys.add(made_of(campaign, Choice(), Source(effects, text)))
    assert len(keys) == 6


# The desk, with a worker that says what the test says.


@pytest.fixture
def desk(campaign, monkeypatch):
    def hire(self):
        self._process = SimpleNamespace(
            is_alive=lambda: True, kill=lambda: None, join=lambda seconds: None
        )
        self._orders = SimpleNamespace(send=lambda order: None)

    monkeypatch.setattr(Desk, "_hire", hire)
    return Desk(campaign, None)


def in_a_loop(session):
    """The desk's orders need a running loop; a browser's test has one of its own in this thread."""
    with ThreadPoolExecutor(1) as thread:
        thread.submit(lambda: asyncio.run(session())).result()


def say(desk, *messages):
    for message in messages:
        desk._hear(desk._orders, message)


def kept(desk):
    return [found.verdict for found in read_session(desk.campaign).diagnoses.values()]


def test_undo_brings_the_diagnosis_back(desk):
    async def session():
        desk.diagnose()
        say(desk, HALF, WHOLE, Concluded(VERDICT, FINDINGS), Done())
        run = desk.campaign.runs[0]
        for change in (
            lambda: desk.set_role(run.id, "validate" if run.role == "fit" else "fit"),
            lambda: desk.toggle_run(run.id),
            lambda: desk.toggle_channel(desk.campaign.channels[0].name),
        ):
            change()
            assert desk.diagnosis is None and desk.ranking is None
            assert kept(desk) == [VERDICT]
            desk.undo()
            assert desk.diagnosis.verdict == VERDICT
            assert desk.ranking.rows == WHOLE.rows
            assert desk.ranking.traces == HALF.traces
        other = "validate" if run.role == "fit" else "fit"
        desk.set_role(run.id, other)
        desk.set_role(run.id, run.role)  # by hand
        assert desk.diagnosis.verdict == VERDICT

        desk.toggle_run(run.id)  # of other data there is another one
        desk.diagnose()
        other = replace(VERDICT, headline="Nothing is missing")
        say(desk, HALF, Concluded(other, ()), Done())
        assert kept(desk) == [VERDICT, other]
        desk.undo()
        assert desk.diagnosis.verdict == VERDICT
        opened_again = Desk(desk.campaign, None)
        assert opened_again.diagnosis.verdict == VERDICT
        assert opened_again.diagnosis.findings == FINDINGS
        assert opened_again.ranking.rows == WHOLE.rows

    in_a_loop(session)


def test_stop_takes_nothing_away(desk):
    async def session():
        desk.diagnose()
        say(desk, HALF)
        desk.cancel()
        assert desk.ranking.rows == HALF.rows
        assert desk.diagnosis is None
        desk.diagnose()
        say(desk, WHOLE, Concluded(VERDICT, ()), Done())
        desk.diagnose()
        desk.cancel()
        assert desk.ranking.rows == WHOLE.rows
        desk.diagnose()
        say(desk, HALF)
        desk.add("bump-stop")  # another wish ends it, too
        assert desk.ranking.rows == WHOLE.rows
        assert desk.diagnosis.verdict == VERDICT
        law = Law(("F = 3 v",), "")
        desk.find("law")
        say(desk, law, Done())
        desk.find("law")
        desk.cancel()
        assert desk.beside(Law) == law
        desk.take_out("bump-stop")
        assert desk.beside(Law) is None  # that one was beside the bump stop
        desk.undo()
        assert desk.beside(Law) == law

    in_a_loop(session)


def test_what_the_worker_says_late_is_of_the_model_it_was_found_beside(desk):
    """A model is chosen while another wish is worked off: its answer is not about that model."""

    async def session():
        desk.find("axles")
        desk.add("bump-stop")
        between = AxleToBody("<p>linear</p>")
        say(desk, between)
        assert desk.beside(AxleToBody) is None
        say(desk, Done())
        desk.undo()
        assert desk.beside(AxleToBody) == between

    in_a_loop(session)


def test_effects_of_one_s_own_make_another_diagnosis(desk, tmp_path):
    async def session():
        desk.diagnose()
        say(desk, WHOLE, Concluded(VERDICT, ()), Done())
        desk.use_effects(Source(tmp_path / "my_effects.py", "not an effect"))
        assert desk.diagnosis is None
        say(desk, Refused("my_effects.py: holds no effect"))
        assert desk.diagnosis.verdict == VERDICT

    in_a_loop(session)


# In a browser.


def test_a_click_loses_no_diagnosis_and_stop_no_ranking(small, tmp_path, open_page):
    folder = shutil.copytree(small, tmp_path / "campaign")
    (folder / "session.toml").write_text(BEFORE_SEVERAL)
    with workbench(folder) as (address, _):
        page = open_page(address)
        page.wait_for_selector("table.heat td:is(.h0, .h1, .h2, .h3, .h4)")
        missing = page.get_by_role("tab", name="What is missing")
        verdict = page.locator(".verdict h2", has_text=HEADLINE)
        ranked = page.locator("table.ranking button", has_text="bump-stop")
        missing.click()
        verdict.wait_for()
        ranked.wait_for()
        page.get_by_role("tab", name="Overview").click()
        page.get_by_role("button", name="fitted").first.click()
        missing.click()
        verdict.wait_for(state="detached")
        assert HEADLINE in (folder / "session.toml").read_text()
        page.get_by_role("button", name="Undo").click()
        verdict.wait_for(timeout=20_000)
        ranked.wait_for()
        page.get_by_role("button", name="Find out what is missing").click()
        page.get_by_text(re.compile("^diagnosing:")).wait_for()
        page.get_by_role("button", name="Stop", exact=True).click()
        page.get_by_text("given up").wait_for()
        verdict.wait_for()
        assert ranked.count() == 1
