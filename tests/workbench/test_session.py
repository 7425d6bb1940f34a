"""The session file: what was decided and found comes back, whatever the names are."""

import tempfile
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.workbench.session import Choice, Session, read_session, write_session
from wheelhop.workbench.shown import Row, Verdict

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
verdicts = st.builds(Verdict, lines, st.floats(0, 1), line, lines, st.just("") | line, lines)
choices = st.builds(
    Choice,
    lines,
    st.lists(st.sampled_from(RUNS), unique=True).map(tuple),
    st.lists(st.sampled_from(CHANNELS), unique=True).map(tuple),
    st.dictionaries(st.sampled_from(RUNS), st.sampled_from(["fit", "validate"])),
)


@given(choices, verdicts, st.lists(rows, max_size=3).map(tuple))
def test_a_session_is_read_as_it_was_written(choice, verdict, ranking):
    with tempfile.TemporaryDirectory() as folder:
        campaign = replace(CAMPAIGN, folder=Path(folder))
        session = Session(choice, verdict, ranking)
        write_session(campaign, session, "wheelhop")
        assert read_session(campaign) == session


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
