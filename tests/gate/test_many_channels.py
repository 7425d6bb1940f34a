"""The gate beside many channels: the same answers as term by term, and no cube of memory."""

import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest

from wheelhop.campaign import Channel
from wheelhop.gate.descriptions import other_descriptions, stated
from wheelhop.gate.drive import HARMONICS, MOST, OnWaves, Passing, speeds_about

POINTS = ("A1", "A2", "A3", "A4", "B1", "B2", "B3", "B4")


class Given(OnWaves):
    """A run whose lines, predicted and measured, are given."""

    def _predicted(self, speeds_m_s, rate):
        return self.paths


def run_of(channels, seed=0):
    """A run with random lines (v, k, c), and random spectral matrices of two sources each."""
    rng = np.random.default_rng(seed)
    shape = len(speeds_about(1.0)), HARMONICS, channels

    def drawn(*more):
        return rng.normal(size=(*shape, *more)) + 1j * rng.normal(size=(*shape, *more))

    sources = drawn(2)
    measured = sources @ sources.conj().swapaxes(2, 3)
    spectra = SimpleNamespace(power=np.full(channels, 40.0), blocks=20.0)
    return Given(spectra, None, 0.5, (drawn(), measured))


def described(channels):
    named = [Channel(f"c{k}", POINTS[k % len(POINTS)]) for k in range(channels)]
    others = [d for d in other_descriptions(named) if d.speed == d.rate == 1.0]
    return [d.places for d in (stated(named), *others)]


def test_every_description_explains_what_it_explains_term_by_term():
    """Σ over harmonics of |r*q| by its definition, each description's r written out in full."""
    channels, speeds = 9, speeds_about(4.0)
    run, places = run_of(channels), described(9)
    predicted, measured = run.paths
    found = run.match(speeds, places)
    frequency = speeds[:, None] * np.arange(1, HARMONICS + 1) / run.pitch_m
    assert len({len(place.columns) for place in places}) > 3
    for place, match in zip(places, found, strict=True):
        r = predicted.copy()
        for column, source, gain, late_s in zip(
            place.columns, place.order, place.gain, place.late_s, strict=True
        ):
            turn = np.exp(-2j * np.pi * frequency * late_s)
            r[:, :, column] = gain * turn * predicted[:, :, source]
        along = np.einsum("vkc,vkcd,vkd->vk", r.conj(), measured, r).real
        size = (np.abs(r) ** 2).sum(axis=(1, 2))
        reach = np.sqrt(along).sum(axis=1)
        share = np.minimum(reach**2 / size / 2 / run.spectra.power.sum(), MOST)
        best = int(share.argmax())
        assert match.share == pytest.approx(share[best], rel=1e-9)
        assert match.gain == pytest.approx(reach[best] / size[best], rel=1e-9)
        assert match.speed_m_s == speeds[best]


def test_memory_grows_with_the_square_of_the_channels():
    """What the arrays of one match take at most: four times for twice the channels."""

    def peak(channels):
        run, places = run_of(channels), described(channels)
        tracemalloc.start()
        run.match(speeds_about(4.0), places)
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    assert peak(64) < 4.2 * peak(32)


def test_the_rear_axle_follows_in_any_place():
    """What is looked up of a place: the column it holds, turned over or not."""
    lines = np.ones((5, 8, 8), dtype=complex)
    spectra = SimpleNamespace(lines=lines, frequency_hz=np.linspace(1.0, 3.0, 5), resolved=9.0)
    lines[:, 2, 0] = lines[:, 0, 2] = -1.0
    run = Passing(spectra, 1.0, ((0, 2),))
    whole = run.match(np.array([1e9]), described(8))
    assert whole[0].share == 0.0 and max(match.share for match in whole) == MOST
