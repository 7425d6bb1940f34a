"""The session file: what was decided and found comes back, whatever the names are."""

import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.campaign.change import Change, Proposal
from wheelhop.workbench.bench import Workbench
from wheelhop.workbench.session import (
    MOST_RUNS,
    Choice,
    Session,
    first_session,
    made_of,
    read_session,
    write_session,
)
from wheelhop.workbench.shown import Diagnosed, Found, Row, Verdict

CLEAN = Path(__file__).parents[2] / "examples/clean"
CAMPAIGN = read_campaign(CLEAN)
RUNS = [run.id for run in CAMPAIGN.runs]
CHANNELS = [channel.name for channel in CAMPAIGN.channels]

line = st.text(st.characters(exclude_categories=["C", "Z"]), min_size=1, max_size=40)
lines = st.lists(line, max_size=3).map(tuple)
error = st.none() | st.floats(0, 10)
rows = st.builds(
    Row, line, line, error, error, error, st.none() | st.floats(-1e6, 1e6), error, lines, line
)
changes = st.builds(Change, line, lines, st.just("") | line)
fixes = st.lists(st.builds(Proposal, line, st.tuples(changes)), max_size=2).map(tuple)
verdicts = st.builds(
    Verdict, lines, st.floats(0, 1), line, lines, st.just("") | line, lines, st.just(""), fixes
)
choices = st.builds(
    Choice,
    lines,
    st.lists(st.sampled_from(RUNS), unique=True).map(tuple),
    st.lists(st.sampled_from(CHANNELS), unique=True).map(tuple),
    st.dictionaries(st.sampled_from(RUNS), st.sampled_from(["fit", "validate"])),
)


findings = st.lists(st.builds(Found, line, line, fixes), max_size=2).map(tuple)
diagnoses = st.builds(Diagnosed, verdicts, st.lists(rows, max_size=3).map(tuple), findings)


@given(choices, st.dictionaries(line, diagnoses, max_size=3))
def test_a_session_is_read_as_it_was_written(choice, found):
    with tempfile.TemporaryDirectory() as folder:
        campaign = replace(CAMPAIGN, folder=Path(folder))
        session = Session(choice, found)
        write_session(campaign, session, "wheelhop")
        assert read_session(campaign) == session


def test_the_one_diagnosis_of_an_older_file_is_of_its_choice(tmp_path):
    campaign = replace(CAMPAIGN, folder=tmp_path)
    text = f"""format = 1\nwithout_runs = ["{RUNS[0]}"]\n[diagnosis]\neffects = ["none"]
confidence = 0.5\nheadline = "Nothing"\n[[ranking]]\neffect = "backlash"\nplace = "axle"\n"""
    (tmp_path / "session.toml").write_text(text)
    session = read_session(campaign)
    ((key, found),) = session.diagnoses.items()
    assert key == made_of(campaign, session.choice) != made_of(campaign, Choice())
    assert (found.verdict.headline, found.ranking[0].effect) == ("Nothing", "backlash")


def test_without_a_file_nothing_is_decided(tmp_path):
    assert read_session(replace(CAMPAIGN, folder=tmp_path)) == Session()


def test_runs_that_are_gone_are_left_out(tmp_path):
    campaign = replace(CAMPAIGN, folder=tmp_path)
    choice = Choice(without_runs=(RUNS[0], RUNS[1]), roles={RUNS[2]: "validate"})
    write_session(campaign, Session(choice), "wheelhop")
    shorter = replace(campaign, runs=tuple(r for r in campaign.runs if r.id != RUNS[0]))
    assert read_session(shorter).choice == replace(choice, without_runs=(RUNS[1],))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("format = 2", "format = 2"),
        ("format = 1\nadded = 3", "added must be a list of texts"),
        (f'format = 1\n[role]\n"{RUNS[0]}" = "both"', "both"),
        ("format = ", "not valid TOML"),
        ("format = 1\n[[diagnosis]]", "'made_of' is missing"),
        ("format = 1\ndiagnosis = 3", "list of tables"),
    ],
)
def test_what_is_no_session_gets_a_line(tmp_path, text, said):
    (tmp_path / "session.toml").write_text(text)
    with pytest.raises(CampaignError, match=r"session\.toml") as caught:
        read_session(replace(CAMPAIGN, folder=tmp_path))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_choice_takes_runs_and_channels_away():
    choice = Choice((), (RUNS[0],), (CHANNELS[1],), {RUNS[2]: "validate"})
    found = choice.applied(CAMPAIGN)
    assert [run.id for run in found.runs] == RUNS[1:]
    assert [channel.name for channel in found.channels] == [CHANNELS[0], *CHANNELS[2:]]
    assert found.runs[1].role == "validate"
    assert found.runs[0].record.shape[1] == len(CHANNELS) - 1


def test_something_has_to_be_left():
    with pytest.raises(CampaignError, match="take one back in"):
        Choice(without_runs=tuple(RUNS)).applied(CAMPAIGN)
    with pytest.raises(CampaignError, match="take one back in"):
        Choice(without_channels=tuple(CHANNELS)).applied(CAMPAIGN)


def test_of_very_many_runs_some_of_either_role_are_taken():
    many = tuple(replace(run, id=f"{run.id}-{i}") for i in range(600) for run in CAMPAIGN.runs)
    whole = replace(CAMPAIGN, runs=many)
    session = first_session(whole)
    taken = session.choice.applied(whole)
    assert 0.9 * MOST_RUNS < len(taken.runs) <= MOST_RUNS
    assert taken.fit_runs
    assert taken.validate_runs
    assert first_session(CAMPAIGN).choice.without_runs == ()


def write_many(folder, count, whole):
    """A campaign of so many runs; but for those that are `whole`, their files are no recordings."""
    head, *_ = (CLEAN / "campaign.toml").read_text().partition("[[run]]")
    run = (
        '[[run]]\nid = "{0}"\nfile = "{0}.csv"\nrole = "fit"\nspeed_kmph = 5\ntrack.kind = "flat"\n'
    )
    (folder / "campaign.toml").write_text(head + "".join(run.format(i) for i in range(count)))
    shutil.copy(CLEAN / "vehicle.toml", folder)
    rows = CAMPAIGN.runs[0].file.read_text().splitlines(keepends=True)[:421]
    for i in range(count):
        (folder / f"{i}.csv").write_text("".join(rows) if i in whole else "no recording")


def test_of_very_many_runs_only_those_taken_are_read(tmp_path):
    whole = [i * 300 // MOST_RUNS for i in range(MOST_RUNS)]
    write_many(tmp_path, 300, whole)
    bench = Workbench()
    bench.put(tmp_path)
    try:
        assert "300 runs: 200 were read" in bench.desk.notice
        assert "the other 100 are left out" in bench.desk.notice
        read = [int(run.id) for run in bench.desk.campaign.runs if len(run.time_s)]
        assert read == whole
        assert len(bench.desk.choice.applied(bench.desk.campaign).runs) == MOST_RUNS
    finally:
        bench.close()
