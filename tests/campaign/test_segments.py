"""A series is cut where it changes, and nowhere else."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wheelhop.campaign.segments import segments

VARIANCE = np.full(3, 0.1)


def series_of(levels, lengths, seed, scatter=0.3):
    rng = np.random.default_rng(seed)
    steps = np.repeat(np.array(levels, dtype=float), lengths)
    return steps[:, None] + rng.normal(0.0, scatter, (len(steps), 3))


@settings(deadline=None)
@given(st.integers(0, 400), st.integers(2, 9), st.integers(0, 2**32))
def test_the_pieces_are_all_rows_in_order(n, shortest, seed):
    rng = np.random.default_rng(seed)
    found = segments(np.cumsum(rng.normal(size=(n, 3)), axis=0), VARIANCE, shortest)
    assert [row for first, last in found for row in range(first, last)] == list(range(n))
    assert all(last - first >= min(shortest, n) for first, last in found)


def test_what_does_not_change_is_hardly_ever_cut():
    """A cut needs a Bayes factor of n: of 100 noises of 300 rows none or one is cut."""
    cut = [len(segments(series_of([0.0], [300], seed), VARIANCE, 4)) > 1 for seed in range(100)]
    assert sum(cut) <= 1


@settings(deadline=None)
@given(
    st.lists(st.integers(8, 300), min_size=2, max_size=6),
    st.sampled_from([-6.0, 6.0]),
    st.floats(-100.0, 100.0),
    st.integers(0, 2**32),
)
def test_a_step_of_many_deviations_is_found_where_it_is(lengths, step, offset, seed):
    """However short the pieces are beside each other, and wherever zero is."""
    levels = [offset + step * (i % 2) for i in range(len(lengths))]
    found = segments(series_of(levels, lengths, seed), VARIANCE, 4)
    places = [last for _, last in found]
    for place in np.cumsum(lengths):
        assert min(abs(place - np.array(places))) <= 1


def test_a_scatter_that_changes_is_a_change():
    series = np.concatenate([series_of([0.0], [200], 1), series_of([0.0], [200], 2, scatter=2.0)])
    assert [last for _, last in segments(series, VARIANCE, 4)] == pytest.approx([200, 400], abs=4)
