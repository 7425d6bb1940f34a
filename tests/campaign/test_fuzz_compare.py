"""Campaigns nobody would record, compared: a result, or one line that says what is wrong.

`python -m benchmarks.fuzz_campaigns` draws thousands; here are those that once ended otherwise.
"""

import pytest

from benchmarks.fuzz_campaigns import make_pattern, try_case

ONCE_BAD = (36, 37, 47, 84, 97, 99, 112, 116, 162, 175, 213, 315, 334, 344, 370, 1037, 1341, 1372)


@pytest.fixture(scope="module")
def pattern(tmp_path_factory):
    return make_pattern(tmp_path_factory.mktemp("fuzz") / "pattern")


@pytest.mark.parametrize("case", ONCE_BAD)
def test_a_broken_campaign_ends_well(pattern, tmp_path, case):
    changes, code, complaint = try_case(pattern, tmp_path / "case", case)
    assert code in (0, 2) and not complaint, changes


@pytest.mark.slow
@pytest.mark.parametrize("case", [109])
def test_a_broken_campaign_is_diagnosed_to_a_good_end(pattern, tmp_path, case):
    changes, code, complaint = try_case(pattern, tmp_path / "case", case, "diagnose")
    assert code in (0, 2) and not complaint, changes
