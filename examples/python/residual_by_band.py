"""Where in the spectrum a model fails, channel by channel, and the picture of it."""

from pathlib import Path
from tempfile import mkdtemp

import wheelhop as wh

campaign = wh.read(Path(__file__).parents[1] / "open-driver-seat").select(
    "washboard-low-slow", "washboard-high-fast", "herringbone-low-fast"
)
fitted = wh.compare(campaign)

# A third-octave that holds more than the sensors' noise is one where something is missing.
bands = fitted.residuals("band")
print(bands.sort_values("over_floor", ascending=False).head(8).to_string())

figure = wh.plot(fitted)
file = Path(mkdtemp()) / "residuals.png"
figure.savefig(file, dpi=150)
print(f"figure: {file}")
