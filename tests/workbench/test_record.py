"""From the logger to a campaign without leaving the page; the logger is its double."""

import re
import sys

import pytest

from tests.workbench.conftest import describe_vehicle, workbench
from wheelhop.calibration import read_constants
from wheelhop.campaign import read_campaign
from wheelhop.logger import read_log

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals")


def choose(page, what):
    page.get_by_label("what for").click()
    page.get_by_role("option", name=what).click()


def record(page, session, seconds):
    """A session of so many seconds of the logger's; the double's time runs ten times faster."""
    page.get_by_role("button", name="Start recording").click()
    page.wait_for_function(
        """([session, seconds]) => {
          const live = RegExp(String.raw`HOP0000${session}.HOP\\s+recorded\\s+([\\d.]+) s`);
          const found = document.body.innerText.match(live);
          return found && Number(found[1]) > seconds;
        }""",
        arg=[session, seconds],
    )
    page.get_by_role("button", name="Stop", exact=True).click()
    page.get_by_role("button", name="Start recording").wait_for()


def take_only(page, *numbers):
    """Have these stretches taken, each with a speed, and no other."""
    speeds = page.get_by_label("speed, km/h")
    speeds.nth(2).wait_for()
    for i in range(speeds.count()):
        if i in numbers:
            speeds.nth(i).fill("8")
        else:
            page.get_by_role("checkbox", name=f"{i + 1}").click()


def test_calibrate_check_drive_and_a_campaign(tmp_path, open_page, pictures):
    with workbench("--emulated", home=tmp_path) as (address, _):
        page = open_page(address)
        page.get_by_text("An emulated logger is there").wait_for()

        choose(page, "Calibrate")
        record(page, 1, 50.0)
        page.screenshot(path=pictures / "record.png")
        page.get_by_role("button", name="Work out the constants").click()
        page.get_by_text("The constants are in").wait_for()
        page.screenshot(path=pictures / "calibrated.png", full_page=True)
        folder = tmp_path / "wheelhop/recordings"
        assert len(read_constants(folder / "calibration.toml").sensors) == 8

        choose(page, "Check")
        record(page, 2, 46.0)
        page.get_by_role("button", name="Go through the checklist").first.click()
        page.get_by_text("strikes felt by B1 B2 B3 B4 A1 A2 A3 A4").wait_for()
        page.screenshot(path=pictures / "checked.png", full_page=True)

        choose(page, "Synchronicity")
        page.get_by_role("button", name="Are they in step?").first.click()
        page.get_by_text(re.compile("beam.toml")).last.wait_for()

        choose(page, "Drive")
        record(page, 3, 80.0)
        assert not read_log(folder / "HOP00003.HOP").missing
        with page.expect_download() as saved:
            page.get_by_role("button", name="download").first.click()
        assert saved.value.suggested_filename == "HOP00003.HOP"
        page.get_by_role("button", name="Take its stretches as runs").first.click()
        take_only(page, 0, 1)
        describe_vehicle(page)
        page.screenshot(path=pictures / "stretches.png", full_page=True)
        page.get_by_role("button", name="Make the campaign").click()
        page.get_by_role("tab", name="Overview").wait_for()

        made = tmp_path / "wheelhop-campaign"
        runs = read_campaign(made).runs
        assert len(runs) == 2
        assert (made / "calibration.toml").is_file()

        page.get_by_role("tab", name="Record").click()  # what was recorded is still there
        page.get_by_role("button", name="Take its stretches as runs").first.click()
        take_only(page, 2)
        page.get_by_role("button", name="Add these runs to the campaign").click()
        page.get_by_role("button", name="HOP00003-3", exact=True).wait_for()
        assert len(read_campaign(made).runs) == 3


def test_no_logger_gets_a_line(tmp_path, open_page):
    with workbench(home=tmp_path) as (address, _):
        page = open_page(address)
        page.get_by_role("button", name="Start recording").click()
        page.get_by_text(re.compile("no (serial port|logger)")).first.wait_for()
        page.get_by_role("button", name="Start recording").wait_for()
