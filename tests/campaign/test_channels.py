"""[channels]: quantities besides vertical acceleration, what is only known, and stated noise."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.campaign.build import ROWS, csv_text, edit, write_campaign
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.campaign.channel import Channel
from wheelhop.campaign.channels import read_channels
from wheelhop.campaign.known import known_of
from wheelhop.campaign.thin import thinned
from wheelhop.campaign.write import NewRun, add_run, new_campaign
from wheelhop.files import parse_toml
from wheelhop.formats.table import BETWEEN
from wheelhop.logger.recording import Channel as Recorded
from wheelhop.logger.recording import Recording

TABLE = """\
noise_rms_m = 0.0002
noise_rms_rad_s = 0.004

[channels]
B1 = "B1"
dash = { quantity = "acceleration", position = [0.35, 0.0] }
rear = { quantity = "acceleration", position = "B3", axis = "z" }
pot_fl = { quantity = "travel", corner = 1, per_wheel = 0.65, noise_rms_m = 0.001 }
pot_rr = { quantity = "travel", corner = 4, scale_uncertainty = 0.02 }
nose = { quantity = "rate", axis = "pitch" }
rod = { quantity = "force", corner = 2, per_wheel = -1.4 }
seat = { quantity = "acceleration", on = "driver" }
gps = { quantity = "speed" }
ax = { quantity = "acceleration", axis = "x", position = [0.1, 0.0] }
rpm = { quantity = "speed", of = "engine" }
"""
NAMES = ("rod", "B1", "dash", "rear", "pot_fl", "pot_rr", "nose", "seat", "gps", "ax", "rpm")

RADIUS = ", radius_m = 0.3"
WHEEL = f'gps = {{ quantity = "speed", of = "wheel", corner = 2{RADIUS} }}'


@pytest.fixture
def folder(tmp_path):
    write_campaign(tmp_path)
    edit(tmp_path / "campaign.toml", "\n[[run]]", f"{TABLE}\n[[run]]")
    for seed, run in enumerate(("slow", "fast")):
        values = np.random.default_rng(seed).normal(0.0, 0.5, (ROWS, len(NAMES)))
        values[:, NAMES.index("gps")] += 5.0
        (tmp_path / f"runs/{run}.csv").write_text(csv_text(values, NAMES))
    return tmp_path


def test_every_quantity_is_read(folder):
    campaign = read_campaign(folder)
    travel = {"quantity": "travel", "unit": "m"}
    assert campaign.channels == (  # in the order of the columns
        Channel("rod", "S2", quantity="force", unit="N", per_wheel=-1.4),
        Channel("B1", "B1"),
        Channel("dash", "body-xy", 0.35, 0.0),
        Channel("rear", "B3"),
        Channel("pot_fl", "S1", **travel, per_wheel=0.65, noise_rms=0.001),
        Channel(
            "pot_rr", "S4", **travel, noise_rms=2e-4, scale_uncertainty=0.02, gain_uncertainty=0.02
        ),
        Channel("nose", "pitch", quantity="rate", unit="rad/s", noise_rms=0.004),
        Channel("seat", "driver"),
    )
    assert [c.corner for c in campaign.channels] == [1, 0, None, 2, 0, 3, None, None]
    assert campaign.leading.name == "B1"
    assert (campaign.unit, campaign.noise_key, campaign.noise_rms) == (
        "m/s²",
        "noise_rms_m_s2",
        0.12,
    )
    assert campaign.quantities == ("acceleration", "force", "travel", "rate")


def test_what_is_not_compared_is_kept_beside(folder):
    campaign = read_campaign(folder)
    assert {(c.name, c.quantity, c.unit) for c in campaign.known} == {
        ("gps", "speed", "m/s"),
        ("ax", "acceleration", "m/s²"),
        ("rpm", "speed", "rad/s"),
    }
    run = campaign.runs[0]
    assert run.record.shape == (ROWS, 8)
    file = np.loadtxt(folder / "runs/slow.csv", delimiter=",", skiprows=1)
    for name in ("gps", "ax", "rpm"):
        np.testing.assert_array_equal(run.known[name], file[:, 1 + NAMES.index(name)])


def test_a_wheel_tells_how_a_known_track_was_driven_where_nothing_else_does(folder):
    """By the radius it rolls on; engine and wheels turn as they show, about their mean."""
    edit(folder / "campaign.toml", 'gps = { quantity = "speed" }', WHEEL)
    campaign = read_campaign(folder)
    run = campaign.runs[0]
    assert run.driven.channel == "gps"
    assert run.speed_m_s == pytest.approx(0.3 * run.known["gps"].mean(), rel=1e-3)
    both = np.concatenate([each.known["gps"] for each in campaign.runs])
    turned = known_of(campaign, run).wheels
    assert list(turned) == [1] and turned[1].stated_m_s == pytest.approx(both.mean())
    assert known_of(campaign, run).engine is None  # it stands
    assert list(known_of(campaign, run).pushed) == ["x"]


def test_of_a_wheel_whose_radius_nobody_knows_no_speed_is_told(folder):
    edit(folder / "campaign.toml", 'gps = { quantity = "speed" }', WHEEL.replace(RADIUS, ""))
    assert read_campaign(folder).runs[0].driven is None


def test_what_is_kept_is_made_lighter_with_the_rest(folder):
    for seed, run in enumerate(("slow", "fast")):
        values = np.random.default_rng(seed).normal(3.0, 0.4, (4 * ROWS, len(NAMES)))
        table = np.column_stack([np.arange(len(values)) / 400.0, values])
        head = ",".join(("time_s", *NAMES))
        file = folder / f"runs/{run}.csv"
        np.savetxt(file, table, "%.6f", ",", header=head, comments="")
    edit(folder / "campaign.toml", "sample_rate_hz = 100.0", "sample_rate_hz = 400.0")
    light, full = thinned(read_campaign(folder)).runs[0], read_campaign(folder).runs[0]
    np.testing.assert_allclose(light.known["gps"][0], full.known["gps"][:4].mean())
    assert light.known["gps"].shape == light.time_s.shape


def test_pots_alone_are_a_campaign(folder):
    """Then travel is what all counts in."""
    toml = folder / "campaign.toml"
    text = toml.read_text()
    begin, end = text.index("B1 = "), text.index("pot_fl")
    toml.write_text(text[:begin] + text[end:].replace("noise_rms_m_s2 = 0.12\n", ""))
    edit(toml, "noise_rms_m_s2 = 0.12\n", "")
    edit(toml, "rod = ", "# rod = ")
    edit(toml, "seat = ", "# seat = ")
    campaign = read_campaign(folder)
    assert (campaign.unit, campaign.noise_key, campaign.noise_rms) == ("m", "noise_rms_m", 2e-4)


def test_noise_stated_of_every_channel_is_that_of_one_in_the_mean(folder):
    toml = folder / "campaign.toml"
    edit(toml, "noise_rms_m_s2 = 0.12\n", "")
    edit(
        toml,
        'B1 = "B1"',
        'B1 = { quantity = "acceleration", position = "B1", noise_rms_m_s2 = 0.1 }',
    )
    edit(toml, "[0.35, 0.0] }", "[0.35, 0.0], noise_rms_m_s2 = 0.2 }")
    edit(toml, 'axis = "z" }', 'axis = "z", noise_rms_m_s2 = 0.2 }')
    edit(toml, "seat = ", "# seat = ")
    campaign = read_campaign(folder)
    assert campaign.noise_rms == pytest.approx(np.sqrt((0.01 + 2 * 0.04) / 3))
    assert [c.noise_rms for c in campaign.channels[1:4]] == [0.1, 0.2, 0.2]


MISTAKES = {
    "an unknown quantity": (
        'quantity = "travel", corner = 1',
        'quantity = "stroke", corner = 1',
        r"\[channels.pot_fl\]: quantity = 'stroke' is not known; choose from acceleration, travel",
    ),
    "a key of another quantity": (
        'axis = "pitch" }',
        'axis = "pitch", corner = 1 }',
        r"\[channels.nose\]: unknown key 'corner'",
    ),
    "no corner": ("corner = 4, ", "", r"\[channels.pot_rr\]: 'corner' is missing"),
    "a corner that no car has": ("corner = 4", "corner = 5", r"corner = 5 must be 1 \(front left"),
    "an axis that is not modelled": ('"pitch"', '"yaw"', r"axis = 'yaw' is not known"),
    "a curve that is not there": (
        "per_wheel = 0.65",
        'per_wheel = "rocker.csv"',
        "per_wheel = 'rocker.csv': no such file",
    ),
    "a curve of a force": (
        "per_wheel = -1.4",
        'per_wheel = "rocker.csv"',
        "a curve is of travel; of a force give a number",
    ),
    "a ratio of nothing": ("per_wheel = 0.65", "per_wheel = 0", "per_wheel = 0 would show nothing"),
    "no place": (", position = [0.35, 0.0] }", " }", r"\[channels.dash\]: 'position' is missing"),
    "an unknown place": ('position = "B3"', 'position = "B5"', "position: say where the sensor"),
    "two places": ('on = "driver" }', 'on = "driver", position = "B1" }', "on and position both"),
    "a filter of what is only known": (
        'gps = { quantity = "speed" }',
        'gps = { quantity = "speed", filter = { kind = "none" } }',
        "filter: this channel is not compared with the model: delete it",
    ),
    "a corner of the car": (
        'gps = { quantity = "speed" }',
        'gps = { quantity = "speed", corner = 1 }',
        'corner is of a wheel: add of = "wheel", or delete it',
    ),
    "nobody aboard": ('on = "driver"', 'on = "dog"', r"\[channels.seat\]: on = 'dog' is not known"),
    "noise in another unit": (
        "noise_rms_m = 0.001",
        "noise_rms_mm = 1.0",
        r"\[channels.pot_fl\]: 'noise_rms_mm': noise rms is given in metres: write noise_rms_m =",
    ),
    "noise of what is not measured": (
        'nose = { quantity = "rate", axis = "pitch" }\n',
        "",
        "noise_rms_rad_s is the noise of a quantity that no channel measures: delete it",
    ),
    "negative noise": (
        "noise_rms_m = 0.0002",
        "noise_rms_m = -1",
        "noise_rms_m = -1 must be greater",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_a_line_that_names_file_and_key(mistake, folder):
    old, new, line = MISTAKES[mistake]
    edit(folder / "campaign.toml", old, new)
    with pytest.raises(CampaignError, match=line) as error:
        read_campaign(folder)
    assert str(error.value).startswith(str(folder / "campaign.toml"))


def test_something_has_to_be_compared(folder):
    toml = folder / "campaign.toml"
    head, *runs = toml.read_text().split("\n[[run]]")
    head = head[: head.index("noise_rms")] + '\n[channels]\ngps = { quantity = "speed" }\n'
    toml.write_text("\n[[run]]".join([head, *runs]))
    with pytest.raises(CampaignError, match="no channel can be compared with a model"):
        read_campaign(folder)


@pytest.mark.parametrize(
    ("column", "said", "hint"),
    [
        ("pot_fl", "no sensor of travel measures more than 5; is it in millimetres", "to m"),
        ("nose", "no sensor of rate measures more than 100; is it in degrees", "to rad/s"),
    ],
)
def test_columns_in_other_units_are_named(column, said, hint, folder):
    values = np.random.default_rng(0).normal(0.0, 0.5, (ROWS, len(NAMES)))
    values[:, NAMES.index(column)] *= 1000.0
    (folder / "runs/slow.csv").write_text(csv_text(values, NAMES))
    with pytest.raises(CampaignError, match=f"{said}.*Convert {column} {hint}"):
        read_campaign(folder)


def test_a_column_may_say_that_it_is_in_millimetres(folder):
    edit(folder / "campaign.toml", "pot_rr =", "pot_rr_mm =")
    names = tuple("pot_rr_mm" if name == "pot_rr" else name for name in NAMES)
    values = np.random.default_rng(0).normal(0.0, 0.5, (ROWS, len(NAMES)))
    (folder / "runs/slow.csv").write_text(csv_text(values, names))
    with pytest.raises(CampaignError, match="pot_rr_mm is in mm by its name, the campaign takes m"):
        read_campaign(folder)


def recording_of(units):
    values = np.random.default_rng(3).normal(3.0, 0.4, (ROWS, len(units)))
    return Recording(values, 100.0, tuple(Recorded(*item) for item in units))


def test_a_campaign_is_made_of_what_was_recorded(tmp_path):
    """A word says of a channel what its table would; a mapping's point may be such a word, too."""
    recording = recording_of(
        [
            ("dash", "m/s²", "B1"),
            ("pot", "m", "travel:3:0.65"),
            ("nose", "rad/s"),
            ("gps", "m/s"),
            ("rpm", "rad/s"),
            ("whl", "rad/s"),
            ("along", "m/s²"),
            ("cushion", "m/s²"),
        ]
    )
    places = {
        "nose": "rate:pitch",
        "gps": "speed",
        "rpm": {"quantity": "speed", "of": "engine"},
        "whl": "speed:wheel:3:0.27",
        "along": "along:x",
        "cushion": "on:driver",
    }
    new_campaign(tmp_path / "c", "of all kinds", recording, places)
    run = NewRun("slow", "fit", 9.0, {"kind": "washboard", "amplitude_mm": 15, "pitch_mm": 400})
    add_run(tmp_path / "c", recording, run)
    campaign = read_campaign(tmp_path / "c")
    assert campaign.channels == (
        Channel("dash", "B1"),
        Channel("pot", "S3", quantity="travel", unit="m", per_wheel=0.65),
        Channel("nose", "pitch", quantity="rate", unit="rad/s"),
        Channel("cushion", "driver"),
    )
    *two, wheel, along = campaign.known
    assert [(c.name, c.unit) for c in two] == [("gps", "m/s"), ("rpm", "rad/s")]
    assert (wheel.point, wheel.unit, wheel.radius_m) == ("A3", "rad/s", 0.27)
    assert (along.quantity, along.axis) == ("acceleration", "x")
    np.testing.assert_allclose(campaign.runs[0].record[:, 1], recording.values[:, 1], rtol=1e-5)


def test_a_channel_that_was_resampled_states_its_noise(tmp_path):
    """What it may have done between its samples; one that states its noise keeps that."""
    kinds = [("pot", "m", "travel:1"), ("gyro", "rad/s", "rate:pitch"), ("B1", "m/s²", "B1")]
    like = recording_of(kinds)
    notes = {f"{BETWEEN}{name}": rms for name, rms in (("pot", "0.0012"), ("B1", "0.3"))}
    like = replace(like, notes=notes)
    stated = {"quantity": "travel", "corner": 1, "noise_rms_m": 0.5}
    places = {"pot": "travel:1", "gyro": "rate:pitch"}
    for folder, pot, noise in (("a", "travel:1", 0.0012), ("b", stated, 0.5)):
        new_campaign(tmp_path / folder, "pots", like, places | {"pot": pot})
        text = (tmp_path / folder / "campaign.toml").read_text()
        assert f"noise_rms_m = {noise}" in text and text.count("noise_rms") == 1


def test_a_run_in_another_unit_is_not_added(tmp_path):
    new_campaign(tmp_path / "c", "pots", recording_of([("pot", "m", "travel:1")]), {})
    run = NewRun("slow", "fit", 9.0, {"kind": "unknown"})
    with pytest.raises(
        CampaignError, match="channel pot is in V, a campaign takes m: say its unit"
    ):
        add_run(tmp_path / "c", recording_of([("pot", "V")]), run)


def test_a_word_with_too_many_parts_is_named(tmp_path):
    with pytest.raises(CampaignError, match="rate:pitch:2: rate has only axis"):
        new_campaign(tmp_path / "c", "x", recording_of([("a", "rad/s", "rate:pitch:2")]), {})


def test_who_is_asked_where_a_channel_sits_learns_of_other_quantities(tmp_path):
    with pytest.raises(CampaignError, match="of other quantities travel:CORNER"):
        new_campaign(tmp_path / "c", "x", recording_of([("stroke", "m")]), {})


def test_the_page_on_channels_shows_a_campaign_that_reads():
    page = (Path(__file__).parents[2] / "docs" / "channels.md").read_text(encoding="utf-8")
    example, *_ = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    said = read_channels(parse_toml(example, Path("campaign.toml"), CampaignError))
    assert {c.quantity for c in said.compared} == {"acceleration", "travel", "rate", "force"}
    assert [c.name for c in said.known] == ["gps", "ax", "rpm", "whl_rl"]
    assert [c.noise_rms for c in said.compared if c.name in ("pot_fl", "roll_rate", "rod_fl")] == [
        *(2e-4, 0.004, 8.0)
    ]
