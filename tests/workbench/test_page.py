"""The page as a user meets it: real clicks in a real browser."""

import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tests.component.cases import CASES as RIG_CASES
from tests.component.cases import DAMPER
from tests.component.rig import make_campaign as make_rig_campaign
from tests.patience import PATIENCE_S, wait_until
from tests.workbench.conftest import describe_vehicle, settle, workbench
from tests.workbench.test_asked import without_time
from tests.workbench.test_draft import NAMES, write_foreign
from wheelhop.campaign import read_campaign

FINDING_MS = 1000 * PATIENCE_S
ROUND = re.compile(r"(\d+\.\d+|\d+)")


def figure(page, name):
    """A number of the head, such as "error / floor"."""
    found = page.locator("dl.key div", has_text=name).locator("dd").inner_text()
    return float(ROUND.findall(found)[-1])


def turn(page, name):
    page.get_by_role("tab", name=name).click()
    settle(page)  # the picture, for those who look at it


def kept_speeds(home):
    """How many runs of the draft on the disk go at 10 km/h."""
    return sum(file.read_text().count("10.0,") for file in home.rglob("draft.json"))


def find_out(page):
    turn(page, "What is missing")
    page.get_by_role("button", name="Find out what is missing").click()
    page.wait_for_selector(".verdict", timeout=FINDING_MS)
    return page.locator(".verdict h2").inner_text()


def assert_script_repeats(folder):
    """The script comes to the same numbers, from nothing but the campaign's files."""
    file = folder / "tables" / "parameters.csv"
    before = pd.read_csv(file, index_col=0)
    file.unlink()
    done = subprocess.run(
        [sys.executable, str(folder / "repeat.py")], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    again = pd.read_csv(file, index_col=0)
    assert list(again.index) == list(before.index)
    np.testing.assert_allclose(again["value"], before["value"], rtol=0.02)


def test_from_a_campaign_to_a_report(friction, open_page, pictures):
    with workbench(friction) as (address, process):
        page = open_page(address)
        page.wait_for_selector("table.heat td.h4")
        assert figure(page, "error / floor") > 3
        page.screenshot(path=pictures / "overview.png")

        turn(page, "Where it fails")
        page.get_by_role("heading", name="Where it fails").wait_for()
        page.screenshot(path=pictures / "where.png", full_page=True)

        turn(page, "What is missing")
        page.get_by_role("button", name="Find out what is missing").click()
        page.wait_for_selector("table.ranking tbody tr", timeout=FINDING_MS)
        assert page.locator(".verdict").count() == 0  # the ranking comes before the end
        page.screenshot(path=pictures / "ranking.png", full_page=True)
        page.wait_for_selector(".verdict", timeout=FINDING_MS)
        assert "dry-friction" in page.locator(".verdict h2").inner_text()
        numbers = page.locator(".verdict .numbers").inner_text()
        assert re.match(r"dry-friction: front \d.* N, rear \d.* N\. Error .* → .* %\.", numbers)
        assert page.locator("button.link.accepted").inner_text() == "dry-friction"
        page.screenshot(path=pictures / "verdict.png", full_page=True)
        shown = "to first order, where that shows best"
        nothing = "holds nothing of its signature"  # a bar would earn less than its numbers cost
        page.locator("summary", has_text="more explain too little").click()
        for effect, words in (("bump-stop", shown), ("anti-roll-bar", nothing)):
            page.get_by_role("button", name=effect, exact=True).click()
            page.locator(".card").get_by_text(words).wait_for()
        turn(page, "Where it fails")
        assert "dry-friction" in page.locator("ol.chain .link", has_text="strut").inner_text()
        turn(page, "What is missing")

        second = open_page(address)  # another tab: the same state
        turn(second, "What is missing")
        assert "dry-friction" in second.locator(".verdict h2").inner_text()
        page.bring_to_front()  # a browser paints a tab in the background once a second

        page.locator(".verdict").get_by_role("button", name="Add dry-friction to the model").click()
        page.locator("dl.key", has_text="baseline + dry-friction").wait_for()
        assert figure(page, "error / floor") < 1.1
        second.locator("dl.key", has_text="baseline + dry-friction").wait_for()
        page.locator(".verdict h2", has_text="In the model now: dry-friction").wait_for()
        page.screenshot(path=pictures / "model.png", full_page=True)
        turn(page, "Compare")
        page.screenshot(path=pictures / "compare.png")
        page.get_by_role("button", name="Play it back").click()
        page.get_by_role("button", name="Play", exact=True).click()
        page.wait_for_function("document.querySelector('[data-part=time]').value > 0.2")
        page.get_by_role("button", name="Pause").click()
        page.screenshot(path=pictures / "playback.png")

        turn(page, "Axle to body")
        page.get_by_role("button", name="Identify it").click()
        page.get_by_role("heading", name="Linear between axle and body?").wait_for()
        assert "a linear mechanism explains all" not in page.inner_text("[data-view=between]")
        page.get_by_text("With dry-friction the model is not linear").wait_for()
        page.screenshot(path=pictures / "axle-to-body.png", full_page=True)

        turn(page, "Take away")
        page.get_by_role("button", name="Write the report", exact=True).click()
        page.get_by_text("report.html", exact=False).first.wait_for()
        link = page.get_by_role("link", name="Look at the report")
        link.wait_for()
        with page.context.expect_page() as opened:
            link.click()
        assert "dry-friction" in opened.value.locator("h1").inner_text()
        page.bring_to_front()
        page.get_by_role("button", name="Write the summary", exact=True).click()
        with page.expect_download() as taken:
            page.get_by_role("link", name="Download summary.html").click()
        assert numbers in taken.value.path().read_text()
        page.get_by_role("button", name="Write the report as PDF").click()
        page.get_by_text(f"written: {friction / 'report.pdf'}").wait_for()
        assert (friction / "report.pdf").read_bytes().startswith(b"%PDF")
        assert "dry-friction" in (friction / "report.html").read_text()
        for name, file in (("figures", "typical.png"), ("tables", "signals.parquet")):
            page.get_by_role("button", name=f"Write the {name}", exact=True).click()
            page.get_by_text(f"written: {friction / name}").wait_for()
            assert (friction / name / file).stat().st_size > 10_000
        page.get_by_role("button", name="Write a script").click()
        page.get_by_text("repeat.py").first.wait_for()
        page.screenshot(path=pictures / "take-away.png")
        assert_script_repeats(friction)

        page.get_by_role("button", name="Undo").click()
        page.locator("dl.key dd", has_text=re.compile("^baseline$")).wait_for()
        page.get_by_role("button", name="Redo").click()
        page.locator("dl.key", has_text="baseline + dry-friction").wait_for()
        process.kill()

    with workbench(friction) as (address, _):  # the server was killed, nothing is lost
        page = open_page(address)
        page.locator("dl.key", has_text="baseline + dry-friction").wait_for()
        turn(page, "What is missing")
        assert "dry-friction" in page.locator(".verdict h2").inner_text()
        page.reload()
        page.locator("dl.key", has_text="baseline + dry-friction").wait_for()


def test_nothing_is_missing(clean, open_page, pictures):
    with workbench(clean) as (address, _):
        page = open_page(address)
        assert find_out(page).startswith("Nothing is missing")
        assert page.locator(".verdict h3").inner_text() == "none"
        assert "dry-friction" in page.locator(".verdict details").last.text_content()
        assert page.locator(".verdict button.primary").count() == 0
        page.screenshot(path=pictures / "none.png", full_page=True)


def rig(folder, component, seconds=5.0):
    return make_rig_campaign(folder, "displacement", component, seed=1, noise=0.01, seconds=seconds)


def test_a_component_on_a_rig(tmp_path, open_page, pictures):
    folder = rig(tmp_path / "rig", RIG_CASES["dry-friction"].component("displacement"))
    with workbench(folder) as (address, _):
        page = open_page(address)
        assert "dry-friction" in find_out(page)
        page.screenshot(path=pictures / "rig.png", full_page=True)
        turn(page, "Overview")
        page.screenshot(path=pictures / "rig-overview.png")
        tabs = page.get_by_role("tab").all_inner_texts()
        assert "Struts" in tabs and not {"Vehicle", "Axle to body"} & set(tabs)


def test_what_no_effect_explains_is_unknown(tmp_path, open_page, pictures):
    numbers = {"quadratic_N_s2_m2": 4.0 * DAMPER.damping_N_s_m}
    folder = rig(tmp_path / "rig", replace(DAMPER, hidden="choking-damper", numbers=numbers), 3.0)
    with workbench(folder) as (address, _):
        page = open_page(address)
        find_out(page)
        assert page.locator(".verdict h3").inner_text().endswith("unknown")
        page.screenshot(path=pictures / "unknown.png", full_page=True)
        page.get_by_role("button", name="Find the missing force").click()
        found = page.locator("[data-view=missing] pre", has_text="It is one of compression.")
        found.wait_for(timeout=FINDING_MS)
        page.screenshot(path=pictures / "law.png", full_page=True)


def test_a_diagnosis_that_is_stopped_has_the_verdict_so_far(small_open, open_page):
    page = open_page(small_open)
    page.wait_for_selector("table.heat td:is(.h0, .h1, .h2, .h3, .h4)")  # the model is fitted
    turn(page, "What is missing")
    page.get_by_role("button", name="Find out what is missing").click()
    page.get_by_text("diagnosing:").wait_for()
    page.get_by_role("button", name="Stop", exact=True).click()
    page.get_by_role("button", name="Find out what is missing").wait_for()
    page.locator(".verdict").first.wait_for()  # `test_worker` says what it is worth


def test_runs_and_channels_are_left_out_and_taken_back(small_open, open_page, pictures):
    page = open_page(small_open)
    page.wait_for_selector("table.heat td.h0")
    page.get_by_role("button", name="leave out").first.click()
    page.wait_for_selector("tr.out")
    page.get_by_role("button", name="take in").click()
    page.wait_for_selector("tr.out", state="detached")
    turn(page, "The model")
    page.get_by_role("heading", name="How the fit converges").wait_for()
    page.screenshot(path=pictures / "converging.png")


def test_three_files_become_a_campaign(tmp_path, open_page, pictures):
    files = write_foreign(tmp_path)
    files[0] = files[0].rename(tmp_path / "a lawn, 7,5 kmh.csv")
    with workbench(home=tmp_path) as (address, process):
        page = open_page(address)
        page.set_input_files("input[type=file]", [str(file) for file in files[::-1]])
        speeds = page.get_by_label("speed, km/h")
        speeds.nth(2).wait_for()
        assert speeds.nth(0).input_value() == "7.5"  # as its name says
        for i in range(3):
            speeds.nth(i).fill("10")
        wait_until(lambda: kept_speeds(tmp_path) == 3)
        process.kill()
    with workbench(home=tmp_path) as (address, _):
        page = open_page(address)
        speeds = page.get_by_label("speed, km/h")
        speeds.nth(2).wait_for()
        assert speeds.nth(2).input_value() == "10"  # the server was killed, nothing is lost

        begin = page.locator(".stretches [data-edge=from]").first
        begin.scroll_into_view_if_needed()
        box, whole = begin.bounding_box(), page.locator(".stretches").first.bounding_box()
        page.mouse.move(box["x"] + 2, box["y"] + 20)
        page.mouse.down()
        page.mouse.move(whole["x"] + 0.4 * whole["width"], box["y"] + 20, steps=3)
        page.mouse.up()
        begin.press("ArrowRight")
        page.wait_for_function("document.querySelector('[aria-label=\"from, s\"]').value > 8.05")

        page.get_by_role("button", name="Make the campaign").click()
        page.get_by_text("still needed: weight on both front wheels").wait_for()
        describe_vehicle(page)
        page.screenshot(path=pictures / "guide.png", full_page=True)
        page.get_by_label("new folder").fill(str(tmp_path / "made"))
        page.get_by_role("button", name="Make the campaign").click()
        page.get_by_role("tab", name="Overview").wait_for()
        for point in NAMES:
            assert page.locator("svg.plan text", has_text=point).count() >= 1
    assert not list(tmp_path.rglob("draft.json"))
    lengths = {run.id: len(run.time_s) for run in read_campaign(tmp_path / "made").runs}
    assert len(lengths) == 3
    assert lengths["a-lawn-7-5-kmh"] == pytest.approx((15.5 - 8.1) * 100, abs=15)


def test_what_a_recording_does_not_say_is_asked_on_the_page(tmp_path, open_page, pictures):
    with workbench(home=tmp_path) as (address, _):
        page = open_page(address)
        page.set_input_files("input[type=file]", str(without_time(tmp_path)))
        page.get_by_role("heading", name="What drive.csv does not say").wait_for()
        page.get_by_text("no column is time").wait_for()
        page.screenshot(path=pictures / "asked.png", full_page=True)
        field = page.get_by_label("rate_hz: how many samples a second has, a number")
        field.fill("often")
        page.get_by_role("button", name="Read it so").click()
        page.get_by_text("rate_hz = often is no number of samples a second").wait_for()
        field.fill("100")
        field.press("Enter")
        page.get_by_label("speed, km/h").first.wait_for()
        assert page.get_by_text("does not say").count() == 0
        assert page.get_by_text("8 channels, 100 Hz").count() == 1
