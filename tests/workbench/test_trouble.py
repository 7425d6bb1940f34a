"""What goes wrong around the page costs nothing that was done, and gets a line."""

import shutil
import signal
import sys
import time

import pytest

from tests.workbench.conftest import workbench

FITTED = "table.heat td:is(.h0, .h1, .h2, .h3, .h4)"


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGSTOP")
def test_a_server_that_slept_goes_on_and_a_folder_that_went_is_named(small, tmp_path, open_page):
    folder = tmp_path / "campaign"
    shutil.copytree(small, folder, ignore=shutil.ignore_patterns("session.toml"))
    (folder / "session.toml").mkdir()  # as of a folder that may not be written to
    (folder / "figures").symlink_to("gone")
    with workbench(folder) as (address, process):
        page = open_page(address)
        page.wait_for_selector(FITTED)
        page.evaluate("window.same = true")
        process.send_signal(signal.SIGSTOP)
        time.sleep(3.0)
        process.send_signal(signal.SIGCONT)
        page.get_by_role("button", name="leave out").first.click()
        page.wait_for_selector("tr.out")
        page.get_by_text("the session is not kept").wait_for()
        stop = page.get_by_role("button", name="Stop", exact=True)
        stop.wait_for()
        stop.wait_for(state="hidden")  # until then what was fitted before is shown at once
        page.wait_for_selector(FITTED)
        assert page.evaluate("window.same")  # no reload was needed

        page.get_by_role("tab", name="Take away").click()
        page.get_by_role("button", name="Write the figures").click()
        page.get_by_text("figures: cannot be made").wait_for()
        page.get_by_role("tab", name="Overview").click()

        folder.rename(tmp_path / "elsewhere")
        page.get_by_role("button", name="take in").first.click()
        page.get_by_text("no such folder").wait_for()
        page.get_by_role("tab", name="Compare").click()  # and the page lives
        page.get_by_role("button", name="Next run").wait_for()


def test_an_effect_s_file_is_shown_before_it_runs(small, tmp_path, open_page, pictures):
    """All of it, what cannot be seen included, and not another text than was shown."""
    ran, file = tmp_path / "ran", small / "my_effects.py"
    much = "# \u202e much before it\n" + "#\n" * 20_000
    text = f"{much}open({str(ran)!r}, 'w')\nraise RuntimeError('not an effect')\n"
    file.write_text("x = 1\n", encoding="utf-8")
    with workbench(small) as (address, _):
        page = open_page(address)
        page.wait_for_selector(FITTED)
        page.get_by_role("tab", name="What is missing").click()
        page.get_by_text("An effect of your own").click()
        field = page.get_by_label("file, such as my_effects.py")
        field.fill(str(file))
        field.press("Enter")  # a click could miss the button while its fold still opens
        page.locator("pre", has_text="x = 1").wait_for()
        file.write_text(text, encoding="utf-8")
        page.get_by_role("button", name="Load it").click()
        changed = page.locator(".bench-notice", has_text="has changed since it was shown")
        changed.wait_for()
        page.get_by_role("button", name="Look at it").click()
        page.locator("pre", has_text="not an effect").wait_for()
        page.locator("pre", has_text="\\u202e much before it").wait_for()
        page.screenshot(path=pictures / "own-effect.png")
        page.get_by_role("button", name="Leave it").click()
        page.get_by_role("button", name="Look at it").click()
        assert not ran.exists()
        page.get_by_role("button", name="Load it").click()
        page.locator(".bench-notice", has_text="my_effects.py: does not run").wait_for()
        assert ran.exists()
        page.get_by_role("tab", name="Overview").click()
        page.get_by_role("button", name="leave out").first.click()  # without it the work goes on
        page.wait_for_selector(FITTED)
    file.unlink()
