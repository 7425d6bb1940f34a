"""A remedy that is a change of campaign.toml, once made, makes the finding go."""

import re
import shutil
import tomllib
from pathlib import Path

import pandas as pd
import pytest

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.campaign.change import Change, changed, rewrite, rewritten
from wheelhop.gate import gate
from wheelhop.vehicle import read_nominal

CLEAN = Path(__file__).parents[2] / "examples/clean"
EXCHANGED = ("washboard-low-slow", "washboard-high-fast")
KEPT = 8  # runs, every second one


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    folder = shutil.copytree(CLEAN, tmp_path_factory.mktemp("clean") / "campaign")
    head, *runs = (folder / "campaign.toml").read_text().split("[[run]]")
    kept = [run for run in runs if any(name in run for name in EXCHANGED)]
    kept += [run for run in runs[::2] if run not in kept][: KEPT - len(kept)]
    (folder / "campaign.toml").write_text("[[run]]".join([head, *kept]))
    return folder


def columns(**changes):
    """A table with columns made of those that are there."""

    def spoil(folder):
        for file in folder.glob("runs/*.csv"):
            table = pd.read_csv(file)
            table.assign(**{n: make(table) for n, make in changes.items()}).to_csv(
                file, index=False
            )

    return spoil


def text(pattern, replacement, file="campaign.toml"):
    def spoil(folder):
        path = folder / file
        path.write_text(re.sub(pattern, replacement, path.read_text()))

    return spoil


def exchange_files(folder):
    one, other = (
        folder / f"runs/{run}.csv" for run in ("washboard-low-slow", "washboard-high-fast")
    )
    one.rename(folder / "x")
    other.rename(one)
    (folder / "x").rename(other)


MISTAKES = {
    "an axle sensor upside down": ("polarity", columns(A2=lambda t: -t.A2)),
    "two exchanged": ("swapped", columns(A1=lambda t: t.A3, A3=lambda t: t.A1)),
    "in g": (
        "units",
        columns(
            **{
                f"{p}{i}": (lambda t, n=f"{p}{i}": t[n] / 9.80665)
                for p in "AB"
                for i in (1, 2, 3, 4)
            }
        ),
    ),
    "speeds in m/s": (
        "speed",
        text(r"speed_kmph = (\S+)", lambda m: f"speed_kmph = {float(m[1]) / 3.6:.6g}"),
    ),
    "heights in cm": (
        "units",
        text(r"amplitude_mm = (\S+)", lambda m: f"amplitude_mm = {float(m[1]) / 10}"),
    ),
    "noise in mm/s²": ("noise", text(r"noise_rms_m_s2 = (\S+)", r"noise_rms_m_s2 = 81.0")),
    "two recordings exchanged": ("runs-exchanged", exchange_files),
    "a spring in N/mm": (
        "no-vehicle",
        text(
            r"(\[suspension.front\]\n)stiffness_N_m = \S+",
            r"\1stiffness_N_m = 10.5",
            "vehicle.toml",
        ),
    ),
}


def found(folder):
    campaign = read_campaign(folder)
    return {f.kind: f for f in gate(campaign, read_nominal(campaign)).findings}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_change_that_is_proposed_mends_it(clean, tmp_path, mistake):
    kind, spoil = MISTAKES[mistake]
    folder = shutil.copytree(clean, tmp_path / "spoilt")
    spoil(folder)
    finding = found(folder)[kind]
    last = finding.fixes[-1].changes
    rewrite(folder, rewritten(folder, last), lambda file, draft: None)
    assert kind not in found(folder)


def test_comments_stay_and_what_is_wrong_changes_nothing(clean, tmp_path):
    folder = shutil.copytree(clean, tmp_path / "campaign")
    file = folder / "campaign.toml"
    file.write_text(re.sub("band_hz = .*", "band_hz = [0.5, 30.0]  # as agreed", file.read_text()))
    before = file.read_text()
    change = (
        Change("campaign.toml", ("band_hz",), "[1.0, 12.0]"),
        Change("campaign.toml", ("run", "washboard-low-slow", "track", "pitch_mm"), "410.0"),
        Change("campaign.toml", ("noise_rms_m_s2",), ""),
    )
    after = changed(before, change, file)
    assert "band_hz = [1.0, 12.0]  # as agreed" in after
    assert "noise_rms_m_s2" not in after
    assert tomllib.loads(after)["run"][0]["track"]["pitch_mm"] == 410.0

    files = rewritten(folder, change)
    assert {line[:1] for line in files[0].lines()} <= {"+", "-", " ", ""}

    def refuse(path, draft):
        raise CampaignError(f"{path}: no")

    with pytest.raises(CampaignError):
        rewrite(folder, files, refuse)
    assert file.read_text() == before
    file.write_text(f"{before}# somebody else\n")
    with pytest.raises(CampaignError, match="meanwhile"):
        rewrite(folder, files, lambda file, draft: None)
    for wrong in (
        Change("campaign.toml", ("title",), "no quotes"),
        Change("campaign.toml", ("run", "nobody", "role"), '"fit"'),
        Change("campaign.toml", ("title", "x"), "1"),
    ):
        with pytest.raises(CampaignError):
            rewritten(folder, [wrong])
