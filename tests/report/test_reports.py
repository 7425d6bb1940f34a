"""What the pages must hold, and that they are whole by themselves."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from tests.report.small import ROWS
from wheelhop.diagnose import NextRun
from wheelhop.effects import load_effects
from wheelhop.files.words import percent
from wheelhop.report.page import bullets
from wheelhop.report.reports import write_comparison_report, write_diagnosis_report
from wheelhop.report.words import headline

VOID = {"meta", "br", "img", "link", "input", "hr"}
LARGEST = 5e6  # bytes


class Page(HTMLParser):
    """Text, ids and references of a page; fails where tags do not match."""

    def __init__(self, html):
        super().__init__()
        self.open, self.text, self.tags, self.ids, self.references = [], "", [], [], []
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        if tag not in VOID:
            self.open.append(tag)
        for name, value in attributes:
            if name == "id":
                self.ids.append(value)
            if name in ("src", "href", "xlink:href", "data", "action"):
                self.references.append(value)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        self.handle_endtag(tag)

    def handle_endtag(self, tag):
        assert tag in VOID or self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-1:] != ["style"]:
            self.text += data


def page_of(path):
    html = path.read_text(encoding="utf-8")
    assert len(html.encode()) < LARGEST
    return html, Page(html)


@pytest.fixture(scope="session")
def pages(friction, clean, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    for name, case in (("friction", friction), ("clean", clean)):
        file = folder / f"{name}.html"
        write_diagnosis_report(file, case.campaign, case.diagnosis, case.library)
    compared = folder / "compared.html"
    write_comparison_report(compared, friction.campaign, friction.diagnosis.ladder)
    baseline = folder / "baseline.html"
    write_comparison_report(baseline, friction.campaign, friction.diagnosis.ladder[:1])
    return {file.stem: page_of(file) for file in folder.iterdir()}


@pytest.mark.parametrize("name", ["friction", "clean", "compared", "baseline"])
def test_a_page_is_whole_by_itself(pages, name):
    html, page = pages[name]
    assert html.startswith("<!doctype html>")
    assert "script" not in page.tags and "link" not in page.tags and "img" not in page.tags
    assert not re.search(r"https?://|url\((?!#)|@import", html)
    assert all(reference.startswith("#") for reference in page.references)
    assert len(page.ids) == len(set(page.ids))
    assert {reference[1:] for reference in page.references} <= set(page.ids)
    assert set(re.findall(r"url\(#([^)]+)\)", html)) <= set(page.ids)
    assert page.tags.count("h1") == 1
    assert "nan" not in re.findall(r"[a-z]+", page.text)


def test_the_page_says_what_was_found(pages, friction):
    _, page = pages["friction"]
    assert friction.diagnosis.verdict == ("dry-friction",)
    first, last = friction.diagnosis.ladder
    assert "The model lacks dry-friction: Coulomb friction in the strut" in page.text
    for number in (first.rung.error_fit, first.rung.error_validate, last.rung.error_validate):
        assert percent(number) in page.text
    assert percent(last.comparison.floor.error_validate) in page.text
    for effect in friction.library.values():
        assert effect.id in page.text and effect.title in page.text
    for ranked in friction.diagnosis.ranking:
        assert ranked.reason.replace("e-", "e\u2011") in page.text
    effect = last.rung.model.effects[0]
    assert effect.source in page.text
    for parameter in effect.parameters_for(last.rung.model.values, friction.campaign.channels):
        assert parameter.name in page.text and parameter.meaning in page.text
    for run in ROWS:
        assert run in page.text
    for line in friction.diagnosis.ladder[0].comparison.breakdown.runs_channels.columns:
        assert line in page.text
    assert "stated in campaign.toml" in page.text and "0.081 m/s²" in page.text


def test_a_model_that_lacks_nothing_is_said_to_lack_nothing(pages, clean):
    _, page = pages["clean"]
    assert clean.diagnosis.verdict == ("none",)
    assert "Nothing is missing" in page.text


def test_no_effect_found_is_not_nothing_missing(clean):
    """Where noise hardly leaves as much as the baseline, that is said first."""
    grounds = replace(clean.diagnosis.grounds, by_chance=0.01)
    said = headline(replace(clean.diagnosis, grounds=grounds))
    assert said.startswith("No effect of the library shows, yet")


def test_what_is_left_unexplained_is_said(friction):
    cut = replace(friction.diagnosis, verdict=("unknown",), ladder=friction.diagnosis.ladder[:1])
    assert (
        headline(cut)
        == "Something is missing, and no effect of the library is confirmed as its cause."
    )
    both = replace(friction.diagnosis, verdict=("dry-friction", "unknown"))
    assert headline(both).startswith("The model lacks dry-friction")
    assert headline(both).endswith(
        "Something more is missing, and no effect of the library is confirmed as its cause."
    )


def test_an_effect_that_took_no_part_has_its_reason(friction, tmp_path):
    effects = {**friction.library, "tyre-lift-off": load_effects()["tyre-lift-off"]}
    reason = "does not apply: no run drives over a known track"
    idle = replace(friction.diagnosis.ranking[-1], effect="tyre-lift-off", reason=reason)
    idle = replace(idle, screened_error=None, confirmed_error=None, evidence=None, p_value=None)
    ranking = (*friction.diagnosis.ranking, idle)
    file = tmp_path / "page.html"
    write_diagnosis_report(
        file, friction.campaign, replace(friction.diagnosis, ranking=ranking), effects
    )
    _, page = page_of(file)
    assert "1 effect does not apply" in page.text
    assert "No run drives over a known track: tyre-lift-off." in page.text


def test_what_was_only_screened_is_folded_away(friction, tmp_path):
    """Four in five of the library, on most campaigns; all of it where nothing is missing."""
    best = friction.diagnosis.ranking[0]
    screened = replace(best, confirmed_error=None, validated_error=None, evidence=None)
    screened = replace(screened, effect="bump-stop", reason="screened: others explain far more")
    for ranking in ((best, screened), (screened,)):
        file = tmp_path / "page.html"
        write_diagnosis_report(
            file, friction.campaign, replace(friction.diagnosis, ranking=ranking), friction.library
        )
        _, page = page_of(file)
        assert page.text.count("screened: others explain far more") == 1
        assert "1 effect was screened only" in page.text
        assert ("why, or why not" in page.text) == (best in ranking)


def test_doubts_and_the_run_that_settles_them_are_on_the_page(friction, tmp_path):
    best, *others = friction.diagnosis.ranking
    best = replace(best, ambiguous_with=(("bump-stop", 11.6),))
    run = NextRun("slow", "herringbone", 9.0, ("dry-friction", "bump-stop"), 47.2, 11.6, 4.0)
    diagnosis = replace(friction.diagnosis, ranking=(best, *others), next_run=run)
    file = tmp_path / "page.html"
    write_diagnosis_report(file, friction.campaign, diagnosis, friction.library)
    _, page = page_of(file)
    assert "hard to tell from bump-stop (12°)" in page.text
    assert "Drive herringbone as in slow at 9 km/h" in page.text
    assert "47° apart on it, 12° on the runs at hand" in page.text


def test_what_a_sentence_announces_stands_below_it():
    below = "<ul><li>One.</li><li>Where:<ul><li>Here.</li><li>There.</li></ul></li></ul>"
    assert bullets(["One.", "Where:", "Here.", "There."]) == below
    assert bullets([]) == ""


def test_titles_cannot_break_the_page(friction, tmp_path):
    campaign = replace(friction.campaign, title='<script>alert("&")</script>')
    file = tmp_path / "page.html"
    write_comparison_report(file, campaign, friction.diagnosis.ladder[:1])
    _, page = page_of(file)
    assert "script" not in page.tags
    assert '<script>alert("&")</script>' in page.text


def test_the_comparison_page_shows_the_fall(pages, friction):
    first, last = friction.diagnosis.ladder
    fall = f"from {percent(first.rung.error_validate)} to {percent(last.rung.error_validate)}"
    assert f"With dry-friction the error goes {fall}" in pages["compared"][1].text
    assert "The baseline’s error is" in pages["baseline"][1].text


def test_every_equation_of_the_library_is_drawn():
    from wheelhop.report.svg import equation

    for effect in load_effects().values():
        assert equation(effect.equation).startswith("<svg"), effect.id
    assert equation(r"\unheardof{x} < 1") == r"<code>\unheardof{x} &lt; 1</code>"
