"""Compare measured and modelled runs: error figures, and where the model fails."""

from wheelhop.compare.band import InBand
from wheelhop.compare.breakdown import Breakdown, Grid, Slice, breakdown
from wheelhop.compare.comparison import (
    Comparison,
    OfQuantity,
    compare,
    quantities_to_json,
    to_json,
    where_to_json,
)
from wheelhop.compare.describe import describe, explains_nothing
from wheelhop.compare.floor import (
    NEIGHBOURS,
    Floor,
    estimate_noise,
    estimate_noise_between_samples,
    noise_floor,
)
from wheelhop.compare.locking import Line, Locking
from wheelhop.compare.metrics import ChannelFigures, Peak
from wheelhop.compare.rating import Rating, iso18571
from wheelhop.compare.records import Record, in_band, relative_error
from wheelhop.compare.signals import RunSignals
from wheelhop.compare.terminal import print_comparison
from wheelhop.compare.weights import weighed, with_noise

__all__ = [
    "NEIGHBOURS",
    "Breakdown",
    "ChannelFigures",
    "Comparison",
    "Floor",
    "Grid",
    "InBand",
    "Line",
    "Locking",
    "OfQuantity",
    "Peak",
    "Rating",
    "Record",
    "RunSignals",
    "Slice",
    "breakdown",
    "compare",
    "describe",
    "estimate_noise",
    "estimate_noise_between_samples",
    "explains_nothing",
    "in_band",
    "iso18571",
    "noise_floor",
    "print_comparison",
    "quantities_to_json",
    "relative_error",
    "to_json",
    "weighed",
    "where_to_json",
    "with_noise",
]
