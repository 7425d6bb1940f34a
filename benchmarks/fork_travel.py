"""What linear least squares make of a fork's travel: python -m benchmarks.fork_travel FOLDER

FOLDER is a vehicle campaign of one corner with a channel B1, and its travel in `travel/`, m,
positive in compression, as `mtb-fork` of the measured data has them. The acceleration above the
fork is fitted by its travel, in the runs to fit, and held against the others: by a spring and a
damper, with a mass that moves with the wheel, and by filters of so many samples to either side.
No model can leave less than the best filter but one that is not linear.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Run, read_campaign

Array = NDArray[np.float64]
REACHES = (5, 10, 20, 40)


def in_band(campaign: Campaign, values: Array) -> Array:
    """Columns (n, k) in the campaign's band, by an ideal filter."""
    spectrum = np.fft.rfft(values - values.mean(axis=0), axis=0)
    frequency = np.fft.rfftfreq(len(values), 1.0 / campaign.sample_rate_hz)
    low, high = campaign.band_hz
    spectrum[(frequency < low) | (frequency > high)] = 0.0
    return np.asarray(np.fft.irfft(spectrum, len(values), axis=0))


def columns(campaign: Campaign, run: Run, kind: str | int) -> tuple[Array, Array]:
    """What explains, and the acceleration above."""
    file = campaign.folder / "travel" / run.file.name
    travel = np.loadtxt(file, delimiter=",", skiprows=1)[:, 1]
    rate = np.gradient(travel, 1.0 / campaign.sample_rate_hz)
    if isinstance(kind, int):
        made = [np.roll(travel, k) for k in range(-kind, kind + 1)]
    else:
        again = np.gradient(rate, 1.0 / campaign.sample_rate_hz)
        made = [travel, rate, again][: 3 if "mass" in kind else 2]
    above = next(i for i, c in enumerate(campaign.channels) if c.point == "B1")
    both = in_band(campaign, np.column_stack([*made, run.record[:, above]]))
    return both[:, :-1], both[:, -1]


def main(folder: Path) -> None:
    """Print the share that is left, of the runs to fit and of the others."""
    campaign = read_campaign(folder)
    for kind in ("spring and damper", "spring, damper and mass", *REACHES):
        parts = []
        for runs in (campaign.fit_runs, campaign.validate_runs):
            pairs = [columns(campaign, run, kind) for run in runs]
            parts.append((np.vstack([x for x, _ in pairs]), np.concatenate([y for _, y in pairs])))
        found = np.linalg.lstsq(parts[0][0], parts[0][1], rcond=None)[0]
        left = [np.linalg.norm(y - x @ found) / np.linalg.norm(y) for x, y in parts]
        name = f"filter of ± {kind} samples" if isinstance(kind, int) else kind
        print(f"{name:26s} fitted {100 * left[0]:5.1f} %, held out {100 * left[1]:5.1f} %")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
