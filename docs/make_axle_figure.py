"""Draw the pictures of identify.md: docs/axle-to-body.png, what was identified and models over it,
and docs/predicted.png, a run as it was predicted.

Run it from anywhere: python docs/make_axle_figure.py
"""

from __future__ import annotations

from pathlib import Path

import wheelhop as wh
from wheelhop.campaign import read_campaign
from wheelhop.identify import Structure, identify, linearity, measure, predict
from wheelhop.report.axle_to_body import linear_models, matrix_figure
from wheelhop.report.identified import run_figure

DOCS = Path(__file__).parent
EXAMPLES = DOCS.parent / "examples"


def main() -> None:
    """Draw both."""
    draw_predicted()
    draw_models()


def draw_predicted() -> None:
    """Identify a car with friction, predict its runs, draw the first one held out."""
    measured = measure(read_campaign(EXAMPLES / "open-dry-friction"))
    model = identify(measured.fit, Structure("free"), order=6, noise_rms=measured.noise_rms)
    run_figure(predict(model, measured)[0]).savefig(DOCS / "predicted.png", dpi=110)


def draw_models() -> None:
    """Fit the baseline and the seat, identify, draw."""
    example = EXAMPLES / "open-driver-seat"
    fitted = wh.compare(example, add="driver-seat", progress=lambda text: print(text, flush=True))
    found = linearity(fitted.campaign, fitted.vehicle)
    assert found.model is not None
    figure = matrix_figure(found.model, fitted.campaign, linear_models(fitted.steps))
    figure.savefig(DOCS / "axle-to-body.png", dpi=110)


if __name__ == "__main__":
    main()
