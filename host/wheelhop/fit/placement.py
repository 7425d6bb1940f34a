"""Where a run began and how fast it went: start values by matching harmonics of the track."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from wheelhop.campaign import Campaign, Run
from wheelhop.compare.band import InBand
from wheelhop.fit.bench import Bench
from wheelhop.fit.parameters import SPEED_UNCERTAINTY, speed_uncertainty
from wheelhop.simulate import Model, frequency_response
from wheelhop.track import Track, make_track, wheel_envelope
from wheelhop.vehicle import Drive, System, axle_name, behind_m, corner_position, wheels

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

REACH = 0.2
"""Speeds are sought within this fraction of the nominal one: a hand holds one to a tenth, and what
it is read from may be another tenth off. Where it is known better, or worse, in proportion."""

FEW_SPEEDS = 40

SLIP = 6

UNEXPLAINED = 0.03
"""Share of a record's power that no nominal model explains: a few of its numbers count at a place,
each uncertain by 10 %."""

GAIN = 0.1
"""Half width, of the logarithm, of what a vehicle moves over what its nominal numbers say, which
are uncertain by 10 %. Laws that they lack may halve it, or more: it has the tails of Cauchy's
distribution."""


def find_start(
    campaign: Campaign,
    run: Run,
    model: Model,
    system: System,
    channels: Collection[int] | None = None,
) -> dict[str, float]:
    """Speed (m/s) and start (m) at which the linear model agrees best with a run, or with some of
    its channels, each counting by its noise.

    On a periodic track the start is found modulo the period, as near as can be to a stated one.
    """
    if run.speed_m_s <= 0:
        return {}
    run = replace(run, record=run.record / campaign.noise_scale)
    predicted = np.asarray(~np.isnan(system.output).any(axis=1))
    if channels is not None:
        predicted = predicted & np.isin(np.arange(len(predicted)), list(channels))
    track = make_track(run.track)
    period = _wavelength(run, track.period_m)
    if period is not None:
        return _match_harmonics(campaign, run, model, system, predicted, track, period)
    return _match_shape(campaign, run, model, system, predicted, track)


def seek_again(
    campaign: Campaign, bench: Bench, model: Model, systems: dict[Drive, System]
) -> dict[str, float]:
    """A better speed and start for a run that the baseline could not place, but an effect found
    since can; empty if there is none.

    Two ways: as at first, in the record as it is without the faults of the sensors found; and by
    simulating the whole model on a grid, because a slow drive over long waves is all friction.
    """
    own, run = model.runs[bench.run.id], bench.run
    if "start_m" not in own:
        return {}
    record = run.record
    for effect in model.effects:
        record = effect.restore(
            model.theta(effect, run.id), record, campaign.channels, campaign.sample_rate_hz
        )
    restored = replace(run, record=record)
    trials = [find_start(campaign, restored, model, systems[bench.drive])]
    period = _wavelength(run, bench.simulator.period_m)
    if period is not None and run.start_m is None:
        speeds = _speeds(run, period)
        if len(speeds) > FEW_SPEEDS:  # many waves: the speed at least is known well
            speeds = np.array([own["speed_m_s"]])
        for speed in speeds:
            for phase in np.arange(12) / 12:
                start = own["start_m"] + phase * period
                trials.append({"speed_m_s": float(speed), "start_m": start})
    models = [(model.with_run(run.id, trial), systems) for trial in ({}, *trials)]
    measured = bench.measured[:, bench.predicted].ravel()
    residuals = [measured - bench.coefficients(record) for record in bench.records(models)]
    misfits = [float(residual @ residual) for residual in residuals]
    best = int(np.argmin(misfits))
    return trials[best - 1] if best > 0 else {}


def _shown(campaign: Campaign, system: System, frequency_hz: Array) -> ComplexArray:
    """What the channels show (f, c, wheels), each per its noise scale."""
    response = frequency_response(system, frequency_hz)
    return np.asarray(response / campaign.noise_scale[:, None])


def _wavelength(run: Run, period_m: float | None) -> float | None:
    """The track's period if the run is several of them long, at one speed; else its shape is what
    counts."""
    if run.course is not None:
        return None
    distance = run.speed_m_s * (run.time_s[-1] - run.time_s[0])
    return period_m if period_m is not None and 2 * period_m < distance else None


def _speeds(run: Run, wavelength_m: float) -> Array:
    """Speeds so close that the phase at `wavelength_m` slips by less than 1/`SLIP` over the run."""
    duration = run.time_s[-1] - run.time_s[0]
    reach = REACH * speed_uncertainty(run) / SPEED_UNCERTAINTY
    count = int(np.ceil(2 * reach * run.speed_m_s * duration * SLIP / wavelength_m)) + 1
    return run.speed_m_s * np.linspace(1 - reach, 1 + reach, count)


def _believed(run: Run, speed: float | Array, start_m: Array) -> Array:
    """Logarithm of what is believed of speeds and starts, as far as they are stated."""
    away = np.zeros(np.broadcast_shapes(np.shape(speed), start_m.shape))
    if run.driven is not None and run.driven.uncertainty > 0.0:
        away += ((speed / run.speed_m_s - 1.0) / run.driven.uncertainty) ** 2
    if run.start_m is not None:
        away += ((start_m - run.start_m[0]) / run.start_m[1]) ** 2
    return -0.5 * away


def _behind(model: Model) -> Array:
    """How far each wheel follows the front axle, (wheels,) m."""
    return np.array([behind_m(model.values, i) for i in wheels(model.values)])


def _envelopes(model: Model, track: Track, x: Array) -> Array:
    """Envelope heights (len(x), wheels) at the same x under each wheel."""
    rolling = wheels(model.values)
    heights = np.empty((len(x), len(rolling)))
    for j, i in enumerate(rolling):
        radius = model.values[f"wheel.{axle_name(i)}.radius_m"]
        y = corner_position(model.values, i)[1]
        heights[:, j] = wheel_envelope(track, y, radius, x.min(), x.max()).height(x)
    return heights


def _match_harmonics(
    campaign: Campaign,
    run: Run,
    model: Model,
    system: System,
    predicted: NDArray[np.bool_],
    track: Track,
    period: float,
) -> dict[str, float]:
    speeds = _speeds(run, period)
    samples = 128
    shape = fft.rfft(_envelopes(model, track, np.arange(samples) * period / samples), axis=0)
    phases = np.arange(64) / 64
    cross, power = np.zeros((2, len(speeds), len(phases)))
    taper = np.hanning(len(run.time_s))[:, None]
    measured = taper * (run.record - run.record.mean(axis=0)) * 2 / taper.sum()
    gone = run.time_s if run.driven is None else run.driven.gone(run.time_s)
    once = np.exp(-2j * np.pi * (speeds / period)[:, None] * gone)
    kernel = np.ones_like(once)
    for k in (1, 2, 3):
        kernel = kernel * once
        frequency = k * speeds / period
        inside = (campaign.band_hz[0] <= frequency) & (frequency <= campaign.band_hz[1])
        if not inside.any():
            continue
        line = kernel[inside] @ measured[:, predicted]
        wheel = shape[k] * 2 / samples * np.exp(-2j * np.pi * k * _behind(model) / period)
        response = _shown(campaign, system, frequency[inside])[:, predicted] @ wheel
        response *= campaign.recorded(frequency[inside])[:, predicted]
        turn = np.exp(2j * np.pi * k * phases)
        cross[inside] += (np.einsum("fc,fc->f", response, line.conj())[:, None] * turn).real
        power[inside] += np.einsum("fc,fc->f", response, response.conj()).real[:, None]
    # Of a model that answers too strongly, as a rigid wheel does on short waves, a share counts.
    share = np.clip(cross / np.maximum(power, np.finfo(float).tiny), 0.0, 1.0)
    # Sum of |measured − share · model|² over channels, less the part that none of them changes.
    match = 2 * share * cross - share**2 * power
    starts = phases * period
    if run.start_m is not None:
        starts += period * np.rint((run.start_m[0] - starts) / period)
    band = InBand(len(run.time_s), campaign.sample_rate_hz, campaign.band_hz)
    held = 2.0 * float((band.signal(run.record[:, predicted]) ** 2).mean(axis=0).sum())
    left = 1.0 - match / max(held, float(match.max()), np.finfo(float).tiny) + UNEXPLAINED
    blocks = 2.0 * (run.time_s[-1] - run.time_s[0])
    likely = -0.5 * blocks * np.log(left) + _believed(run, speeds[:, None], starts)
    i, j = np.unravel_index(np.argmax(likely), match.shape)
    return {"speed_m_s": float(speeds[i]), "start_m": float(starts[j])}


def _match_shape(
    campaign: Campaign,
    run: Run,
    model: Model,
    system: System,
    predicted: NDArray[np.bool_],
    track: Track,
) -> dict[str, float]:
    """Correlation of the record with the response to the whole track, for every speed."""
    duration = run.time_s[-1] - run.time_s[0]
    slowest = min((run.speed_m_s,) if run.course is None else run.course.speed_m_s)
    fastest = max((run.speed_m_s,) if run.course is None else run.course.speed_m_s)
    travelled = fastest * duration * (1 + REACH)
    low = max(track.start_m, -2 * travelled) - travelled - 1.0
    high = min(track.end_m, 2 * travelled) + _behind(model).max() + 1.0
    x = np.linspace(low, high, int((high - low) / 0.01) + 1)
    profile = _envelopes(model, track, x)
    step = 1.0 / campaign.sample_rate_hz
    band = InBand(len(run.time_s), campaign.sample_rate_hz, campaign.band_hz)
    measured = band.signal(run.record[:, predicted])
    pieces = _pieces(run, slowest / 8.0)
    drives = {
        v: [_drive(run, v * faster, low, high) for _, faster in pieces]
        for v in _speeds(run, slowest / 8.0)
    }
    # As many samples at every speed: then they share frequencies, and the vehicle's response.
    longest = max(until for each in drives.values() for until, _ in each)
    n = fft.next_fast_len(int(longest / step) + len(measured), real=True)
    frequency = fft.rfftfreq(n, step)
    inside = (campaign.band_hz[0] <= frequency) & (frequency <= campaign.band_hz[1])
    response = _shown(campaign, system, frequency[inside])[:, predicted]
    response *= campaign.recorded(frequency[inside])[:, predicted, None]
    sought = [fft.rfft(measured[rows], n, axis=0)[inside].conj() for rows, _ in pieces]
    held = float((measured**2).sum())
    best = (-np.inf, run.speed_m_s, 0.0)
    for speed, of_pieces in drives.items():
        starts, along, energy = np.zeros((3, 0))
        for (rows, _), wanted, (until, at) in zip(pieces, sought, of_pieces, strict=True):
            # Where speed goes by the place alone, another start is the same drive at another time.
            position = at(step * np.arange(n))
            height = np.empty((n, profile.shape[1]))
            for i, behind in enumerate(_behind(model)):
                height[:, i] = np.interp(position - behind, x, profile[:, i])
            spectrum = np.zeros((len(frequency), len(response[0])), dtype=complex)
            spectrum[inside] = (response @ fft.rfft(height, axis=0)[inside, :, None])[:, :, 0]
            cross = np.zeros(len(frequency), dtype=complex)
            cross[inside] = (spectrum[inside] * wanted).sum(axis=1)
            square = (fft.irfft(spectrum, n, axis=0) ** 2).sum(axis=1)
            power = np.concatenate([[0.0], np.cumsum(square)])
            last = int(until / step)
            shown = power[rows.stop - rows.start :][:last] - power[:last]
            since_s = np.asarray(step * np.arange(last), np.float64)
            begun = _begun(run, speed, rows.start, since_s, at)
            common = fft.irfft(cross, n)[:last]
            if len(starts):
                along = along + np.interp(starts, begun, common)
                energy = energy + np.interp(starts, begun, shown)
            else:
                starts, along, energy = begun, common, shown
        match = _likelihood(along, energy, held, 2 * duration) + _believed(run, speed, starts)
        lag = int(np.argmax(match))
        if match[lag] > best[0]:
            best = (float(match[lag]), float(speed), float(starts[lag]))
    return {"speed_m_s": best[1], "start_m": best[2]}


def _pieces(run: Run, wavelength_m: float) -> list[tuple[slice, float]]:
    """Rows of pieces of a run within which its speed is constant as far as the phase at
    `wavelength_m` tells, and their speeds over the run's; without those that get no further."""
    n = len(run.time_s)
    if run.driven is None:
        return [(slice(0, n), 1.0)]
    way = run.speed_m_s * run.driven.gone(run.time_s)
    count, pieces = 1, list[slice]()
    while way[-1] - way[0] > 2 * count * wavelength_m:
        edges = np.linspace(0, n - 1, count + 1).astype(int).tolist()
        pieces = [slice(a, b) for a, b in pairwise(edges)]
        bent = (
            way[p] - np.linspace(way[p.start], way[p.stop], p.stop - p.start + 1)[:-1]
            for p in pieces
        )
        if max(float(np.abs(each).max()) for each in bent) * 2 * SLIP <= wavelength_m:
            break
        count *= 2
    period = float(run.time_s[-1] - run.time_s[0]) / (n - 1)
    gone = [(p, float(way[p.stop] - way[p.start])) for p in pieces]
    return [
        (p, far / ((p.stop - p.start) * period) / run.speed_m_s)
        for p, far in gone
        if far > wavelength_m
    ]


def _begun(run: Run, speed: float, row: int, since_s: Array, at: Callable[[Array], Array]) -> Array:
    """Where the front axle was at time 0 if it passed the places `at` some seconds in that row."""
    if run.driven is None:
        return at(since_s - run.time_s[row])
    return at(since_s) - speed * float(run.driven.gone(run.time_s[row]))


def _likelihood(along: Array, energy: Array, held: float, blocks: float) -> Array:
    """Logarithm of the likelihood (l,) of places where a record that holds so much energy has
    `along` in common with a model's response of some energy.

    The model's gain is free: with its own, flat ground is likeliest wherever the model shows more
    than twice as much as was measured. What is left beside counts as normal noise, half a second as
    one number; a gain is believed to be near 1 (`GAIN`), as far as the response is not lost in what
    no model explains.
    """
    lost = max(UNEXPLAINED * held, np.finfo(float).tiny)
    along, energy = np.maximum(along, 0.0), np.maximum(energy, 0.0)
    share = along**2 / np.maximum(energy, lost) / max(held, lost)
    apart = np.log((along + lost) / (energy + lost)) / GAIN
    left = np.maximum(1.0 - share, 0.0) + UNEXPLAINED
    return np.asarray(-0.5 * blocks * np.log(left) - np.log1p(apart**2))


def _drive(
    run: Run, speed: float, low: float, high: float
) -> tuple[float, Callable[[Array], Array]]:
    """How long a run at a speed takes from one place to another, s, and where it is meanwhile."""
    if run.course is None:
        return (high - low) / speed, lambda time_s: low + speed * time_s
    course, faster = run.course, speed / run.speed_m_s
    first, last = course.time(np.array([low, high]))
    return float(last - first) / faster, lambda time_s: course.place(first + faster * time_s)
