"""A simulated campaign looks measured: it reads back, and nothing but its noise is left of it."""

from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.campaign.proving_ground import proving_ground, table_5_1
from wheelhop.effects import load_effects
from wheelhop.predict import (
    Case,
    Instrument,
    make_campaign,
    make_recording,
    read_drives,
    read_effects,
)
from wheelhop.vehicle import read_vehicle

VEHICLE = Path(__file__).parents[2] / "examples/clean/vehicle.toml"


def case(tracks, speeds=(), effects=(), **more):
    drives = read_drives(tracks, speeds)
    return Case(read_vehicle(VEHICLE), read_effects(effects, load_effects()), drives, **more)


def test_the_proving_ground_is_that_of_the_thesis():
    assert len(read_drives(["table-5.1"], [])) == 18  # section 5.2
    assert set(table_5_1()) < set(proving_ground())
    twist = proving_ground()["chassis-twist/high"]
    assert (twist.keys["amplitude_mm"], twist.keys["pitch_mm"]) == (200, 4000)  # table 4.4
    assert twist.speeds_kmph == (5.5, 14.5)  # table 4.7


def test_a_campaign_reads_back_with_the_tracks_it_was_made_on(tmp_path):
    made = case(["washboard/low", "herringbone/high:angle_deg=10", "half-sine-bump:amplitude_mm=60"
                 ":length_mm=900"], [9.0], seconds=4.0)  # fmt: skip
    make_campaign(tmp_path / "c", made, VEHICLE, Instrument(0.1))
    campaign = read_campaign(tmp_path / "c")
    assert [run.track for run in campaign.runs] == [drive.track for drive in made.drives]
    assert [run.speed_m_s for run in campaign.runs] == [2.5] * 3
    assert campaign.runs[1].track.values["angle_rad"] == pytest.approx(np.radians(10.0))
    assert {run.role for run in campaign.runs} == {"fit", "validate"}
    for run, drive in zip(campaign.runs, made.drives, strict=True):
        number = made.drives.index(drive)
        error = run.record - made.record(number, 100.0, campaign.averaging_s)
        # The noise stated is that in band, 59 % of the whole; there are 3200 numbers.
        assert error.std() == pytest.approx(0.1 / np.sqrt(29.5 / 50.0), rel=0.05)
    folder = {path.name for path in tmp_path.iterdir()}
    assert folder == {"c"}


def test_the_same_seed_gives_the_same_files_and_another_one_does_not(tmp_path):
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        made = case(["washboard/low"], [9.0], ["speed-fluctuation"], seconds=2.5, seed=seed)
        make_campaign(tmp_path / name, made, VEHICLE, Instrument(0.1))
    a, b, c = (
        (tmp_path / name / "runs/washboard-low-9kmph.csv").read_bytes() for name in ("a", "b", "c")
    )
    assert a == b != c


def test_a_run_does_not_depend_on_the_runs_beside_it():
    one = case(["washboard/low"], [9.0], seed=3)
    two = case(["washboard/low", "herringbone/low"], [9.0], seed=3)
    assert np.array_equal(one.record(0, 100.0, 0.0), two.record(0, 100.0, 0.0))


def test_through_the_logger_only_its_rounding_and_clock_are_added(tmp_path):
    made = case(["washboard/low"], [9.0], seconds=4.0)
    make_campaign(tmp_path / "c", made, VEHICLE, Instrument(0.1, logger=True))
    campaign = read_campaign(tmp_path / "c")
    assert (tmp_path / "c/logs/washboard-low-9kmph.hop").exists()
    assert campaign.channels[0].gain_uncertainty > 0.05  # of the data sheet: the user must know
    # Rounding to codes of 0.5 m/s², eight of them in a mean, on top of the sensors' noise.
    assert 0.1 < campaign.noise_rms < 0.2
    record = campaign.runs[0].record
    ideal = made.record(0, 100.0, campaign.averaging_s)
    for column in range(8):
        seen = np.correlate(record[:, column], ideal[:, column], "full").max()
        assert seen / (ideal[:, column] @ ideal[:, column]) == pytest.approx(1.0, abs=0.05)


def test_a_survey_goes_into_the_campaign(tmp_path):
    road = tmp_path / "my road.csv"
    x = np.arange(0.0, 30.0, 0.05)
    z = 0.01 * np.sin(2 * np.pi * x / 2.0)
    np.savetxt(road, np.column_stack([x, z, z]), delimiter=",", header="x_m,left_m,right_m",
               comments="")  # fmt: skip
    made = case([f"profile:file={road}"], [10.0], seconds=4.0)
    make_campaign(tmp_path / "c", made, VEHICLE, Instrument(0.1))
    (run,) = read_campaign(tmp_path / "c").runs
    assert run.id == "my-road-10kmph"
    assert Path(run.track.values["file"]).read_bytes() == road.read_bytes()


def test_what_fails_half_way_leaves_no_folder(tmp_path, monkeypatch):
    made = case(["washboard/low"], [9.0, 10.0], seconds=2.5)
    record = Case.record

    def fails(self, number, *rest):
        if number == 1:
            raise CampaignError("the disk is full")
        return record(self, number, *rest)

    monkeypatch.setattr(Case, "record", fails)
    with pytest.raises(CampaignError, match="disk is full"):
        make_campaign(tmp_path / "new/c", made, VEHICLE, Instrument(0.1))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_use_stays_as_it_is(tmp_path):
    (tmp_path / "mine").write_text("dear to me")
    with pytest.raises(CampaignError, match="not empty"):
        make_campaign(tmp_path, case(["washboard/low"], [9.0]), VEHICLE, Instrument(0.1))
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".hop"])
def test_one_recording(suffix, tmp_path):
    from wheelhop.campaign.recorded import read_recording

    file = tmp_path / f"run{suffix}"
    make_recording(file, case(["washboard/low"], [9.0], seconds=3.0), Instrument(0.1))
    recording = read_recording(file, nominal=True)
    assert recording.rate_hz == 100.0 and len(recording.values) / 100.0 >= 3.0
    assert {channel.point for channel in recording.channels} == {
        f"{kind}{i}" for kind in "AB" for i in (1, 2, 3, 4)
    }


def test_effects_change_what_is_recorded_and_their_values_matter():
    plain = case(["washboard/low"], [9.0], seed=1).record(0, 100.0, 0.0)
    some, more = (
        case(["washboard/low"], [9.0], [f"dry-friction:front_N={n}:rear_N={n}"], seed=1).record(
            0, 100.0, 0.0
        )
        for n in (20, 60)
    )
    changes = [np.sqrt(np.mean((record - plain) ** 2)) for record in (some, more)]
    assert 0.0 < changes[0] < changes[1]


@pytest.mark.parametrize("seed", range(3))
def test_a_driver_lets_the_speed_wander_as_drivers_do(seed):
    """Some per cent of it, within seconds, as the fit believes of them: not from knot to knot."""
    one = case(["washboard/high"], [11.0], ["speed-fluctuation"], seed=seed)
    simulator = one._simulator(0, 100.0, 0.0, 0.0)
    way = simulator.way(one._model(0, simulator))[:, 0]
    speed = np.diff(way) * 100.0
    assert 0.02 < speed.std() / speed.mean() < 0.06
    assert np.abs(np.diff(speed)).max() * 100.0 < 1.0  # m/s²
