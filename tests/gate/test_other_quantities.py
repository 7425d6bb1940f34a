"""What users do wrong with potentiometers, gyros and strain gauges is named, and what is right is
left alone."""

from dataclasses import replace

import numpy as np
import pytest

from tests import truth
from tests.truth import Sensor
from wheelhop.campaign import TrackSpec, read_campaign
from wheelhop.cli.main import main
from wheelhop.compare import weighed
from wheelhop.gate import gate
from wheelhop.gate.drive import Nominal, drive_of
from wheelhop.gate.gate import _evened
from wheelhop.gate.identities import identity_findings
from wheelhop.gate.match import Places
from wheelhop.gate.records import noise_findings
from wheelhop.gate.spectra import spectra_of
from wheelhop.vehicle import read_nominal

AXLES = tuple(Sensor(f"A{i}", "acceleration", f"A{i}", 0.1) for i in (1, 2, 3, 4))
RODS = tuple(Sensor(f"rod{i}", "force", str(i), 8.0, -1.4, -700.0) for i in (1, 2, 3, 4))
INCHES = 1 / 0.0254
TIME = np.arange(600) / 100.0


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    folder = truth.make_campaign(
        tmp_path_factory.mktemp("driven"),
        seed=101,
        effects={"dry-friction": {"coulomb_front_N": 75.0, "coulomb_rear_N": 55.0}},
        short=True,
        seconds=6.0,
        draft=True,
        sensors=(*truth.SENSORS, *AXLES, *RODS),
    )
    campaign = read_campaign(folder)
    return campaign, read_nominal(campaign)


def without(campaign, *quantities, axles=True):
    """The campaign without channels of these quantities, or those of the axles."""
    kept = [
        i
        for i, c in enumerate(campaign.channels)
        if c.quantity not in quantities and (axles or not c.is_axle)
    ]
    runs = tuple(replace(run, record=run.record[:, kept]) for run in campaign.runs)
    return replace(campaign, channels=tuple(campaign.channels[i] for i in kept), runs=runs)


def changed(campaign, how):
    """Records changed by `how`, which gets the record and the column of every name."""
    place = {channel.name: i for i, channel in enumerate(campaign.channels)}
    runs = []
    for run in campaign.runs:
        record = run.record.copy()
        how(record, place)
        runs.append(replace(run, record=record))
    return replace(campaign, runs=tuple(runs))


def times(factor, *names):
    def how(record, place):
        record[:, [place[name] for name in names]] *= factor

    return how


def swap(a, b):
    def how(record, place):
        record[:, [place[a], place[b]]] = record[:, [place[b], place[a]]]

    return how


def late(samples, *names):
    def how(record, place):
        columns = [place[name] for name in names]
        record[samples:, columns] = record[:-samples, columns]

    return how


def stuck(name):
    def how(record, place):
        record[100:400, place[name]] = record[100, place[name]]

    return how


def at_its_end(name):
    def how(record, place):
        middle, spread = record[:, place[name]].mean(), record[:, place[name]].std()
        record[:, place[name]] = np.minimum(record[:, place[name]], middle + 0.8 * spread)

    return how


POTS = ("pot1", "pot2", "pot3", "pot4")
GYROS = ("pitch_rate", "roll_rate")
MISTAKES = {
    "a pot reversed": (times(-1.0, "pot3"), "polarity", "pot3"),
    "all pots in millimetres": (times(1e3, *POTS), "units", "in mm"),
    "a pot in inches": (times(INCHES, "pot2"), "units", "pot2"),
    "two pots exchanged": (swap("pot1", "pot4"), "swapped misplaced", "pot1"),
    "gyros in degrees": (times(180 / np.pi, *GYROS), "units", "deg/s"),
    "a gyro reversed": (times(-1.0, "pitch_rate"), "polarity", "pitch_rate"),
    "forces in kilonewtons": (times(1e-3, "rod1", "rod2", "rod3", "rod4"), "units", "kN"),
    "a rod reversed": (times(-1.0, "rod2"), "polarity", "rod2"),
    "pots late": (late(8, *POTS), "out-of-step", "travel are 80 ms late"),
    "a pot stuck": (stuck("pot1"), "stuck", "pot1"),
    "a pot at its end": (at_its_end("pot4"), "clipping", "at its end"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
@pytest.mark.parametrize("axles", [True, False], ids=["axles measured", "no axles"])
def test_a_mistake_is_named(mistake, axles, driven):
    campaign, vehicle = driven
    how, kinds, words = MISTAKES[mistake]
    found = gate(changed(without(campaign, axles=axles), how), vehicle).findings
    named = [f for f in found if f.kind in kinds.split()]
    assert any(words in f"{f.text} {f.about} {f.remedy}" for f in named), found


@pytest.mark.parametrize(
    "lacks",
    [(), ("acceleration",), ("travel",), ("rate",), ("force", "rate"), ("acceleration", "rate")],
)
def test_good_campaigns_pass_in_silence(lacks, driven):
    """Pots rest at centimetres, rods at 700 N: no gravity is missing, and nothing is in codes."""
    campaign, vehicle = driven
    campaign = without(campaign, *lacks)
    if lacks:  # the noise is stated of what is left
        first = campaign.channels[0]
        noise = campaign.noise_rms if campaign.leading.is_acceleration else first.noise_rms
        campaign = replace(campaign, noise_rms=noise)
    assert gate(campaign, vehicle).findings == ()


UNSURVEYED = {
    "a pot reversed": (times(-1.0, "pot3"), "polarity", "pot3"),
    "a pot in inches": (times(INCHES, "pot2"), "units", "in inch"),
    "two pots exchanged": (swap("pot1", "pot4"), "misplaced", "corner 4"),
    "gyros in degrees": (times(180 / np.pi, *GYROS), "units", "deg/s"),
    "a gyro reversed": (times(-1.0, "roll_rate"), "polarity", "roll_rate"),
}
ON_TRACKS = ("a pot in inches", "gyros in degrees", "a pot reversed")
"""These are always asked of surveyed roads."""


@pytest.mark.parametrize(
    "mistake",
    [
        pytest.param(name, marks=pytest.mark.slow if name in ON_TRACKS else ())
        for name in UNSURVEYED
    ],
)
def test_accelerometers_tell_on_any_road(mistake, driven):
    campaign, vehicle = driven
    unknown = TrackSpec("unknown", {})
    runs = tuple(replace(run, track=unknown) for run in campaign.runs)
    campaign = replace(campaign, runs=runs)
    assert gate(campaign, vehicle).findings == ()
    how, kind, words = UNSURVEYED[mistake]
    found = gate(changed(campaign, how), vehicle).findings
    assert any(f.kind == kind and words in f"{f.text} {f.about}" for f in found), found


def forgotten(*corners):
    """campaign.toml says nothing of the ratio of these corners' pots, which is 0.65."""

    def how(campaign):
        channels = tuple(
            replace(c, per_wheel=1.0) if c.quantity == "travel" and c.corner in corners else c
            for c in campaign.channels
        )
        return replace(campaign, channels=channels)

    return how


def recorded(how):
    return lambda campaign: changed(campaign, how)


BY_TRAVEL = {
    "a pot reversed": (recorded(times(-1.0, "pot3")), "polarity", "pot3"),
    "ratio forgotten": (forgotten(0, 1, 2, 3), "ratio", "pot1"),
    "ratio of the rear end": (forgotten(2, 3), "ratio", "pot3"),
    "gyros converted twice": (recorded(times(np.pi / 180, *GYROS)), "units", "rad/s converted"),
    "a gyro reversed": (recorded(times(-1.0, "roll_rate")), "polarity", "roll_rate"),
    "pots 0.3 s late": (recorded(late(30, *POTS)), "out-of-step", "travel are 300 ms late"),
    "accelerations in g": (
        recorded(times(1 / 9.80665, "B1", "B2", "B3", "B4")),
        "units",
        "in g",
    ),
    "two pots exchanged": (recorded(swap("pot1", "pot4")), "swapped", "pot1"),
}


@pytest.fixture(scope="module")
def on_any_road(driven):
    """Pots, the body's accelerometers and gyros, on a road that nobody described."""
    campaign, vehicle = driven
    unknown = TrackSpec("unknown", {})
    campaign = without(campaign, "force", axles=False)
    runs = tuple(replace(run, track=unknown) for run in campaign.runs)
    return replace(campaign, runs=runs), vehicle


def test_good_travel_passes_in_silence_on_any_road(on_any_road):
    assert gate(*on_any_road).findings == ()


@pytest.mark.parametrize("mistake", BY_TRAVEL)
def test_the_body_tells_what_is_wrong_of_travel_on_any_road(mistake, on_any_road):
    """What the struts do is all that moves the body."""
    campaign, vehicle = on_any_road
    how, kind, words = BY_TRAVEL[mistake]
    found = gate(how(campaign), vehicle).findings
    assert any(f.kind == kind and words in f"{f.text} {f.about}" for f in found), found


def test_accelerometers_at_both_ends_show_the_ratio(driven):
    campaign, vehicle = driven
    found = gate(forgotten(1)(campaign), vehicle).findings
    assert "per_wheel of pot2" in {f.about for f in found if f.kind == "ratio"}


def test_check_says_what_every_channel_is_and_what_is_kept(tmp_path, capsys):
    sensors = (*truth.SENSORS[:5], *truth.SENSORS[8:], RODS[0])
    folder = truth.make_campaign(
        tmp_path, seed=3, effects={}, short=True, seconds=3.0, draft=True, sensors=sensors
    )
    toml = folder / "campaign.toml"
    text = toml.read_text().replace("noise_rms_N = 8\n", "")
    toml.write_text(text.replace("[channels]\n", '[channels]\ngps = { quantity = "speed" }\n'))
    for file in (folder / "runs").glob("*.csv"):
        head, *rows = file.read_text().splitlines()
        file.write_text("\n".join([f"{head},gps", *(f"{row},2.5" for row in rows)]) + "\n")
    assert main(["check", str(folder)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    for words in (
        "pot1 (travel of strut 1, 0.65 per wheel)",
        "pitch_rate (rate of pitch)",
        "rod1 (force of strut 1, -1.4 per wheel)",
        "speed as gps shows it, in 8 of 8 runs",
        "0.1 m/s², 0.0002 m, 0.004 rad/s rms in band; of force not stated, will be estimated",
        "axle, body: m/s²; travel: m; rate: rad/s; force: N rms without the mean",
    ):
        assert words in said, (words, said)


@pytest.mark.parametrize(
    ("spring", "damper", "said"), [(1.0, 1.7, set()), (0.8, 1.0, set()), (2.0, 2.0, {"ratio"})]
)
def test_a_damper_that_is_not_as_stated_is_no_wrong_ratio(spring, damper, said, on_any_road):
    """It moves the body as a wrong ratio of the end's potentiometers would, but for the spring,
    which such a ratio would change alike."""
    campaign, vehicle = on_any_road
    times = {"stiffness_N_m": spring, "damping_N_s_m": damper}
    rear = {f"suspension.rear.{key}": factor for key, factor in times.items()}
    changed = vehicle.with_values({key: factor * vehicle[key] for key, factor in rear.items()})
    believed = {key: factor * vehicle.uncertainty[key] for key, factor in rear.items()}
    changed = replace(changed, uncertainty={**vehicle.uncertainty, **believed})
    assert {finding.kind for finding in gate(campaign, changed).findings} == said


@pytest.mark.parametrize(("times", "named"), [(1.0, False), (1.4, False), (3.0, True)])
def test_the_noise_of_one_sensor_is_known_as_well_as_its_amplitudes_are_many(driven, times, named):
    """Of white noise the quietest quarter of the band, in the quietest of eight short runs, holds
    less than half of it by chance; stated three times as large it is not that."""
    rng, first, said = np.random.default_rng(4), driven[0].runs[0], []
    for _ in range(20):
        runs = tuple(
            replace(first, id=str(i), record=rng.normal(size=(600, 1)), time_s=TIME)
            for i in range(8)
        )
        spectra = [spectra_of(run, 100.0, (0.5, 30.0), np.ones(1)) for run in runs]
        stated = times * np.sqrt(29.5 / 50.0)
        (channel, *_) = (c for c in driven[0].channels if c.is_acceleration)
        campaign = replace(driven[0], channels=(channel,), runs=runs, noise_rms=float(stated))
        said.append(any("more" in each.text for each in noise_findings(campaign, spectra)))
    assert said == [named] * 20


def test_the_likeliest_springs_and_dampers_are_found_whatever_the_description(
    on_any_road, monkeypatch
):
    """As likely as they become at last, within the odds of one to five."""
    campaign, vehicle = on_any_road
    evened = _evened(weighed(campaign))
    nominal = Nominal(evened, vehicle, weighed(campaign).noise_scale)
    spectra = [spectra_of(run, 100.0, (0.5, 30.0), evened.noise_scale) for run in campaign.runs]
    pots = tuple(i for i, c in enumerate(campaign.channels) if c.quantity == "travel")

    def likely(gain):
        place = Places(pots, pots, (gain,) * len(pots), (0.0,) * len(pots))
        drives = (drive_of(evened, each, nominal) for each in spectra)
        return sum(drive.match(np.ones(1), [place])[0].log_likelihood for drive in drives)

    soon = [likely(gain) for gain in (1.0, 1.5, 0.4, 4.0)]
    monkeypatch.setattr("wheelhop.gate.by_travel.ROUNDS", 50)
    at_last = [likely(gain) for gain in (1.0, 1.5, 0.4, 4.0)]
    assert soon == pytest.approx(at_last, abs=np.log(5.0))


def test_ratios_and_clocks_are_wrong_by_as_much_as_people_make_them(on_any_road):
    """Four times, as a ratio of 0.5 that was squared the wrong way round is, which friction makes
    look less; half a second."""
    campaign, vehicle = on_any_road

    def found(change):
        return {
            (f.kind, f.text.split(" all ")[0]) for f in gate(change(campaign), vehicle).findings
        }

    wide = found(recorded(times(3.9, *POTS)))
    (said,) = (text for kind, text in wide if kind == "ratio")
    assert "about 3.1 times" in said or "about 4 times" in said
    behind = found(recorded(late(48, *POTS)))
    assert any(kind == "out-of-step" and "480 ms late" in text for kind, text in behind)


def test_accelerometers_at_both_ends_tell_a_ratio_that_is_two_fifths_off(driven):
    """One that is a fifth off may be their noise."""
    campaign, vehicle = driven
    counted = weighed(campaign)
    for factor, named in ((1.2, False), (1 / 1.2, False), (1.4, True), (1 / 1.4, True)):
        wrong = changed(counted, times(factor, "pot2"))
        said = {(f.kind, f.about) for f in identity_findings(wrong, vehicle.values)}
        assert said == ({("ratio", "per_wheel of pot2")} if named else set()), factor
