"""How well the linear model explains a campaign, and where it fails.

python examples/python/first_comparison.py [CAMPAIGN]
"""

import sys
from pathlib import Path

import wheelhop as wh

here = Path(__file__).parents[1]
campaign = wh.read(sys.argv[1] if len(sys.argv) > 1 else here / "open-dry-friction")
print(campaign)
print(campaign.to_dataframe().to_string())

fitted = wh.compare(campaign)
print(f"\n{fitted}")

# Rows are third-octave bands (centre, Hz), columns are channels: residual over the noise floor.
over_floor = fitted.residuals("band")["over_floor"].unstack(sort=False)
print(over_floor.round(1).to_string())
band_hz, channel = over_floor.stack().idxmax()
print(f"worst: {channel} at {band_hz:g} Hz")
