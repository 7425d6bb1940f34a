"""Draw docs/axle-to-body.png, the picture of identify.md: what was identified, models over it.

Run it from anywhere: python docs/make_axle_figure.py
"""

from __future__ import annotations

from pathlib import Path

import wheelhop as wh
from wheelhop.identify import linearity
from wheelhop.report.axle_to_body import matrix_figure

DOCS = Path(__file__).parent
EXAMPLE = DOCS.parent / "examples/open-driver-seat"


def main() -> None:
    """Fit the baseline and the seat, identify, draw."""
    fitted = wh.compare(EXAMPLE, add="driver-seat", progress=lambda text: print(text, flush=True))
    found = linearity(fitted.campaign, fitted.vehicle)
    assert found.model is not None
    figure = matrix_figure(found.model, fitted.campaign, fitted.steps)
    figure.savefig(DOCS / "axle-to-body.png", dpi=110)


if __name__ == "__main__":
    main()
