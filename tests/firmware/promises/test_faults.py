"""Trials of benchmarks.logger_faults: every scan at its number, whatever happens to the card."""

from pathlib import Path

import pytest

from benchmarks.logger_causes import CAUSES
from benchmarks.logger_faults import trial

THREES = 3  # trials of three causes each, which follow those of one


@pytest.mark.parametrize("seed", range(len(CAUSES) + THREES))
def test_every_decoded_scan_is_its_own_and_every_acknowledged_one_is_there(
    elf, small_files, tmp_path, seed
):
    outcome = trial(seed, tmp_path, Path(elf), Path(small_files))
    assert outcome.wrong == []
    assert outcome.decoded >= outcome.acknowledged > 0
