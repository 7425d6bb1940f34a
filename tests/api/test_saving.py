"""A result is one file: as it was when it is loaded, and nothing that stands in it is run."""

import json
import pickle
import subprocess
import sys
import zipfile
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import wheelhop as wh
from wheelhop.campaign.tracks import read_track
from wheelhop.files import Table
from wheelhop.simulate import RunSimulator


@pytest.fixture(scope="module")
def file(fitted, tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "result.wheelhop"
    fitted.save(path)
    return path


def test_a_loaded_result_is_the_one_saved(file, fitted):
    again = wh.load(file)
    assert repr(again) == repr(fitted) and again.to_json() == fitted.to_json()
    pd.testing.assert_frame_equal(again.parameters(), fitted.parameters())
    pd.testing.assert_frame_equal(again.covariance(), fitted.covariance())
    for run in fitted.campaign:
        np.testing.assert_array_equal(again.campaign[run.id].record, run.record)


def test_a_loaded_result_computes_as_before(file, fitted):
    name = "suspension.front.damping_N_s_m"
    changes = {name: 1.1 * fitted.model.values[name]}
    assert wh.load(file).with_values(changes).error_fit == fitted.with_values(changes).error_fit


def test_a_diagnosis_is_saved_too(found, tmp_path):
    found.save(tmp_path / "d.wheelhop")
    again = wh.load(tmp_path / "d.wheelhop")
    assert again.verdict == found.verdict and again.to_json() == found.to_json()
    pd.testing.assert_frame_equal(again.ranking(), found.ranking())


def test_another_process_unpickles_a_result(fitted, tmp_path):
    (tmp_path / "r.pickle").write_bytes(pickle.dumps(fitted))
    code = f"import pickle; print(pickle.load(open({str(tmp_path / 'r.pickle')!r}, 'rb')))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == repr(fitted), done.stderr


@pytest.mark.parametrize("name", ["compare", "diagnose", "simulate", "predict", "plot", "read"])
def test_functions_go_to_other_processes(name):
    assert pickle.loads(pickle.dumps(getattr(wh, name))) is getattr(wh, name)


def test_the_file_can_be_read_without_wheelhop(file, fitted):
    with zipfile.ZipFile(file) as archive:
        assert json.loads(archive.read("result.json"))["format"] == 1
        assert json.loads(archive.read("about.json"))["campaign"] == fitted.campaign.title
        assert b'id = "dry-friction"' in archive.read("model.toml")


class Calls:
    """A pickle of it calls a function."""

    def __init__(self, function, *arguments):
        self.call = function, arguments

    def __reduce__(self):
        return self.call


def with_state(file, path, state):
    """The saved file with another state."""
    with zipfile.ZipFile(file) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            new.writestr(name, state if name == "state" else old.read(name))
    return path


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (eval, ("1 / 0",)),
        (subprocess.run, (["true"],)),
        (wh.read, ("there-is-no-such-folder",)),  # a function of wheelhop's own
        (RunSimulator.__init__, (1,)),
        (wh.InputError, ("made",)),
        (wh.api.saving.import_module, ("this",)),
    ],
)
def test_a_file_that_would_call_something_is_refused(file, tmp_path, function, arguments):
    state = pickle.dumps(Calls(function, *arguments))
    with pytest.raises(wh.InputError, match=r"bad\.wheelhop"):
        wh.load(with_state(file, tmp_path / "bad.wheelhop", state))


def test_damage_is_one_line(file, tmp_path):
    whole = file.read_bytes()
    path = tmp_path / "broken.wheelhop"
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(wh.InputError, match=r"broken\.wheelhop: is no whole result"):
        wh.load(path)
    with pytest.raises(wh.InputError, match="damaged"):
        wh.load(with_state(file, path, b"\x80\x05abc"))
    with pytest.raises(wh.InputError):
        wh.load(tmp_path / "missing.wheelhop")


def test_another_version_s_file_names_both_versions(file, tmp_path):
    path = tmp_path / "old.wheelhop"
    with zipfile.ZipFile(file) as old, zipfile.ZipFile(path, "w") as new:
        about = json.loads(old.read("about.json")) | {"wheelhop": "0.0.1"}
        new.writestr("about.json", json.dumps(about))
    with pytest.raises(wh.InputError, match=r"written by wheelhop 0\.0\.1.*read_model"):
        wh.load(path)


def test_effects_of_ones_own_come_from_the_user_again(fitted, tmp_path):
    code = "from wheelhop.effects.dry_friction import DryFriction\n\n\nclass Mine(DryFriction):\n"
    own, other = tmp_path / "own.py", tmp_path / "other.py"
    own.write_text(f"{code}    id = 'mine'\n")
    other.write_text(f"{code}    id = 'mine'  # changed\n")
    mine = wh.load_effects(own)["mine"]
    model = replace(fitted.model, effects=(mine,))
    fit = replace(fitted.last.rung.fit, model=model)
    step = replace(fitted.last, rung=replace(fitted.last.rung, fit=fit))
    changed = replace(fitted, steps=(fitted.steps[0], step))
    changed.save(tmp_path / "r.wheelhop")
    for wrong in (None, other):
        with pytest.raises(wh.InputError, match=r'"Mine" of wheelhop_user_.*effects='):
            wh.load(tmp_path / "r.wheelhop", wrong)
    again = wh.load(tmp_path / "r.wheelhop", own)
    assert [effect.id for effect in again.last.rung.fit.model.effects] == ["mine"]


TRACKS = [
    {"kind": "flat"},
    {"kind": "washboard", "amplitude_mm": 15.0, "pitch_mm": 400.0},
    {"kind": "iso8608", "unevenness_m3": 4e-6, "waviness": 2.0, "seed": 1},
    {"kind": "profile", "file": "survey.csv"},
]


@pytest.mark.parametrize("keys", TRACKS, ids=lambda keys: keys["kind"])
def test_runs_on_every_kind_of_track_are_saved(fitted, tmp_path, keys):
    (tmp_path / "survey.csv").write_text(
        "x_m,left_m,right_m\n"
        + "".join(f"{i / 10},{0.01 * (i % 7)},{0.01 * (i % 5)}\n" for i in range(400))
    )
    track = read_track(Table({"track": keys}, tmp_path / "campaign.toml"), tmp_path)
    workshop = pickle.loads(pickle.dumps(fitted.workshop))
    run = replace(fitted.campaign.runs[0], track=track)
    workshop.benches = {run.id: workshop.bench(run)}
    changed = replace(fitted, workshop=workshop)
    changed.save(tmp_path / "r.wheelhop")
    bench = wh.load(tmp_path / "r.wheelhop").workshop.benches[run.id]
    assert bench.simulator.run.track == track
