"""Whatever a name or a recording holds is text on the page, or a line that says what to do."""

import json
import re
import shutil

from tests.workbench.conftest import settle, workbench

NASTY = '<img src=x onerror="document.title=1"><script>document.title=2</script> ../../x & '
LONG = "long " * 700
CHANNEL = "<script>document.title=3</script>" + "x" * 3000


def spoil(folder):
    """Give the campaign, its channels, its first run and that run's file names of a stranger."""
    toml = folder / "campaign.toml"
    text = re.sub(r"title = .*", lambda _: f"title = {json.dumps(NASTY + LONG)}", toml.read_text())
    first = re.search(r'file = "(.*)"', text)[1]
    file = "runs/<img src=x onerror=alert(1)> .. &amp;.csv"
    text = text.replace(json.dumps(first), json.dumps(file))
    text = re.sub(r'id = ".*"', lambda _: f"id = {json.dumps(NASTY + LONG)}", text, count=1)
    (folder / first).rename(folder / file)
    for recording in folder.glob("runs/*.csv"):
        head, rows = recording.read_text().split("\n", 1)
        recording.write_text(f"{head.replace('B1', CHANNEL)}\n{rows}")
    points = [f"{place}{i}" for place in "AB" for i in (1, 2, 3, 4)]
    names = {CHANNEL if point == "B1" else point: point for point in points}
    table = "".join(f'{json.dumps(name)} = "{point}"\n' for name, point in names.items())
    toml.write_text(text.replace("[[run]]", f"[channels]\n{table}\n[[run]]", 1))


def test_names_are_text_and_nothing_else(small, tmp_path, open_page, pictures):
    folder = shutil.copytree(small, tmp_path / "nasty")
    spoil(folder)
    with workbench(folder) as (address, _):
        page = open_page(address)
        assert page.locator("h1").inner_text().startswith("<img")
        for tab in ("Overview", "Compare", "The model", "Take away"):
            page.get_by_role("tab", name=tab).click()
            settle(page)
            assert page.evaluate("document.documentElement.scrollWidth") <= 1280, tab
            page.screenshot(path=pictures / f"nasty-{tab}.png")
        assert page.locator("img[src=x]").count() == 0
        assert page.title().startswith("wheelhop: <img")


def titled(title):
    def change(folder):
        file = folder / "campaign.toml"
        text = re.sub(r"title = .*", lambda _: f"title = {json.dumps(title)}", file.read_text())
        file.write_text(text)

    return change


def not_a_number(folder):
    file = sorted(folder.glob("runs/*.csv"))[0]
    head, row, rows = file.read_text().split("\n", 2)
    file.write_text(f"{head}\n{re.sub(',[^,]*$', ',nan', row)}\n{rows}")


def gone(folder):
    shutil.rmtree(folder)


def climbing(folder):
    file = folder / "campaign.toml"
    file.write_text(re.sub(r'file = "runs/', 'file = "../runs/', file.read_text(), count=1))


WRONG = {
    "runs/": not_a_number,
    "no such folder": gone,
    "leads out of the campaign folder": climbing,
    "give at most": titled("t" * 10_000),
    "must be a non-empty line": titled("bell \a and escape \x1b[31m"),
}


def test_a_campaign_that_is_none_gets_a_line(small, tmp_path, open_page):
    with workbench(home=tmp_path) as (address, _):
        page = open_page(address)
        for number, (said, spoil) in enumerate(WRONG.items()):
            folder = shutil.copytree(small, tmp_path / f"wrong-{number}")
            spoil(folder)
            page.get_by_label("its folder").fill(str(folder))
            page.get_by_role("button", name="Open", exact=True).click()
            page.locator(".bench-notice", has_text=f"wrong-{number}").filter(
                has_text=said
            ).wait_for()
        assert page.get_by_role("button", name="Open", exact=True).is_enabled()


UP = NASTY.replace(" ", "_").replace("x", "q")  # x would be where the sensor points
HEADS = [f"Acc {UP} axle {side} [g]" for side in ("FL", "FR")]


def test_a_recording_of_a_stranger_is_text(tmp_path, open_page):
    """HTML in the columns' names and in the file's; then what no number is among the samples."""
    rows = [f"{i / 100};{0.001 * (i % 7)};0.0" for i in range(2000)]
    head = "Time [s];" + ";".join(HEADS)
    spoilt = [*rows[:500], "5.0;\x1b[31m;<b>"]
    with workbench(home=tmp_path) as (address, _):
        page = open_page(address)
        for number, body in enumerate((rows, spoilt)):
            file = {
                "name": f"<img src=x onerror=alert(1)> & ..csv{'y' * 150}{number}.csv",
                "mimeType": "text/csv",
                "buffer": "\n".join([head, *body]).encode(),
            }
            page.set_input_files("input[type=file]", [file])
            page.locator(".bench-columns", has_text="<script>document.title=2</script>").wait_for()
            assert page.locator("img[src=x], img[src=q]").count() == 0
        notice = page.locator(".bench-notice:visible", has_text="is not a number")
        notice.wait_for()
        assert "line 502" in notice.inner_text()
        assert "\n" not in notice.inner_text().strip()
