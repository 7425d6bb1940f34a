"""Draw docs/ladder.png, the picture of README.md: a real diagnosis of examples/open-dry-friction.

Run it from anywhere: python docs/make_readme_figure.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from effect_pictures import BASELINE, EFFECT, INK, RULE, SOFT, STYLE
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from wheelhop.campaign import read_campaign
from wheelhop.diagnose import Diagnosis, diagnose
from wheelhop.effects import load_effects
from wheelhop.files.words import percent
from wheelhop.report.cases import Case, cases
from wheelhop.vehicle import read_vehicle

DOCS = Path(__file__).parent
EXAMPLE = DOCS.parent / "examples/open-dry-friction"


def main() -> None:
    """Diagnose, then draw the worst place and the ladder."""
    campaign = read_campaign(EXAMPLE)
    vehicle = read_vehicle(campaign.vehicle_file)
    diagnosis = diagnose(
        campaign, vehicle, load_effects(), progress=lambda text: print(text, flush=True)
    )
    print(f"verdict: {', '.join(diagnosis.verdict)}, confidence {diagnosis.confidence:.2f}")
    worst = cases(campaign.channels, diagnosis.ladder)[0]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.4, 3.3))
        draw_case(
            figure.add_axes((0.06, 0.45, 0.58, 0.4)),
            figure.add_axes((0.06, 0.15, 0.58, 0.23)),
            worst,
            " + ".join(diagnosis.ladder[-1].added),
        )
        draw_ladder(figure.add_axes((0.73, 0.15, 0.25, 0.7)), diagnosis)
        figure.savefig(DOCS / "ladder.png", dpi=110)


def draw_case(upper: Axes, lower: Axes, case: Case, added: str) -> None:
    """Measured and modelled, and what each model leaves."""
    time, shown = case.time_s[case.shown], case.shown
    upper.plot(time, case.measured[shown], color=INK, lw=1.8, label="measured")
    upper.plot(time, case.before[shown], color=BASELINE, label="baseline")
    upper.plot(time, case.after[shown], color=EFFECT, label=f"with {added}")
    noise = 2 * case.noise_rms
    lower.axhspan(-noise, noise, color=RULE, lw=0, label="noise")
    lower.plot(time, (case.measured - case.before)[shown], color=BASELINE)
    lower.plot(time, (case.measured - case.after)[shown], color=EFFECT)
    for axes, ticks in ((upper, 5), (lower, 3)):
        axes.set_xlim(time[0], time[-1])
        axes.yaxis.set_major_locator(MaxNLocator(ticks))
    upper.tick_params(labelbottom=False)
    upper.set_ylabel("m/s²")
    lower.set_ylabel("residual")
    lower.set_xlabel("time, s")
    upper.set_title(f"{case.channel} in {case.run_id}, a run no fit has seen", pad=18)
    upper.legend(loc="lower left", bbox_to_anchor=(-0.01, 0.96), ncols=3, borderaxespad=0.0)


def draw_ladder(axes: Axes, diagnosis: Diagnosis) -> None:
    """The held-out error, rung by rung, down to the noise floor."""
    errors = np.array([step.rung.error for step in diagnosis.ladder])
    floor = diagnosis.ladder[-1].floor
    x = np.arange(len(errors))
    names = ["baseline", *(f"+ {step.added[-1]}" for step in diagnosis.ladder[1:])]
    axes.axhline(100 * floor, color=SOFT, ls=(0, (4, 3)), lw=1.0)
    axes.plot(x, 100 * errors, "o-", color=EFFECT, ms=6)
    axes.plot(x[:1], 100 * errors[:1], "o", color=BASELINE, ms=6)
    for i, error in enumerate(errors):
        axes.annotate(
            percent(error, 2), (i, 100 * error), xytext=(9, 5), textcoords="offset points"
        )
    axes.annotate(
        f"noise floor {percent(floor, 2)}",
        (-0.4, 100 * floor),
        xytext=(2, -11),
        textcoords="offset points",
        color=SOFT,
    )
    axes.set_xticks(x, names)
    axes.tick_params(axis="x", length=0, colors=INK)
    axes.set_xlim(-0.4, len(errors) - 0.4)
    axes.set_yscale("log")
    axes.set_ylim(100 * floor / 1.6, 160 * errors.max())
    axes.yaxis.set_major_locator(LogLocator(base=10, subs=(1, 2, 5)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_ylabel("error E, %")
    axes.set_title("error on the runs held out", pad=18)


if __name__ == "__main__":
    main()
