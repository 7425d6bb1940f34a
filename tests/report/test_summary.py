"""The summary says what the diagnosis says: the same numbers in plain words, on both pages."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from wheelhop.files.words import percent
from wheelhop.report.page import QUESTIONS
from wheelhop.report.summary import GUESS, SURE, answers, write_summary
from wheelhop.report.words import in_numbers


def test_four_answers_with_the_numbers_on_top(friction, tmp_path):
    campaign, diagnosis = friction.campaign, friction.diagnosis
    write_summary(tmp_path / "summary.html", campaign, diagnosis)
    page = (tmp_path / "summary.html").read_text()
    assert in_numbers(diagnosis.ladder) in page and " N" in in_numbers(diagnosis.ladder)
    places = [page.index(f"<dt>{question}</dt>") for question in QUESTIONS]
    assert places == sorted(places) and page.index(" N") < places[0] < page.index("<svg")
    missing, sure, changes, following = answers(diagnosis, campaign)
    assert "dry-friction" in missing
    assert f"{100 * diagnosis.confidence:.0f} %" in sure
    for step in (diagnosis.ladder[0], diagnosis.ladder[-1]):
        assert percent(step.rung.error) in changes
    assert following


def test_nothing_missing_changes_nothing(clean):
    missing, _, changes, following = answers(clean.diagnosis, clean.campaign)
    assert "Nothing is missing" in missing and changes.startswith("Nothing")
    assert following


@pytest.mark.parametrize("least, words", SURE)
def test_words_for_a_confidence(friction, least, words):
    campaign = friction.campaign
    for confidence, expected in ((least, words), (least - 0.01, None)):
        _, sure, _, _ = answers(replace(friction.diagnosis, confidence=confidence), campaign)
        assert sure.startswith(words) == (expected is not None)
    _, sure, _, _ = answers(replace(friction.diagnosis, confidence=SURE[-1][0] / 2), campaign)
    assert sure.startswith(GUESS)


def test_what_is_unknown_is_left_to_a_force_in_free_form(friction):
    diagnosis = replace(friction.diagnosis, verdict=("unknown",), next_run=None)
    assert "free form" in answers(diagnosis, friction.campaign)[3]
    belief = SimpleNamespace(kind="speed", severity="certain", fixes=("x",), remedy="Mend it.")
    diagnosis = replace(diagnosis, findings=(belief,))
    assert answers(diagnosis, friction.campaign)[3].startswith("Mend it.")
