"""What is written as TOML reads back as it was, whatever a user's text holds."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.campaign.write import NewRun, add_run, new_campaign
from wheelhop.files import quoted, to_toml
from wheelhop.logger.recording import Channel, Recording

# A surrogate is no character: neither TOML nor UTF-8 can hold one.
TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=40)
ODD = ['"quoted"', "back\\slash", "two\nlines", "tab\tbell\a nul\0 del\x7f", "\u202e\u2028", "'''"]
NUMBERS = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(2**63), 2**63 - 1)
VALUES = TEXT | NUMBERS | st.lists(TEXT)


@given(text=TEXT)
def test_a_text_comes_back(text):
    assert tomllib.loads(f"x = {quoted(text)}") == {"x": text}


@given(
    document=st.dictionaries(
        TEXT,
        VALUES | st.dictionaries(TEXT, VALUES, min_size=1, max_size=3),
        max_size=4,
    ),
    rows=st.lists(st.dictionaries(TEXT, VALUES, max_size=3), min_size=1, max_size=3),
)
def test_a_document_comes_back(document, rows):
    whole = {**document, "rows": rows}
    assert tomllib.loads(to_toml(whole)) == whole


def recording():
    values = np.random.default_rng(1).normal(0, 3, (300, 1))
    return Recording(values, 100.0, (Channel("A1", "m/s²"),))


@pytest.mark.parametrize("text", ODD)
def test_a_new_campaign_keeps_odd_words_or_says_in_a_line_that_it_cannot(text, tmp_path):
    folder = tmp_path / "c"
    try:
        new_campaign(folder, text, recording(), {})
    except CampaignError as error:
        assert "\n" not in str(error) and not folder.exists()
        return
    run = NewRun("a", "fit", 7.5, {"kind": "flat"}, source=text)
    odd = replace(recording(), history=(text,))
    add_run(folder, odd, run)
    assert read_campaign(folder).title == text
    assert tomllib.loads((folder / "vehicle.toml").read_text())["name"] == text
