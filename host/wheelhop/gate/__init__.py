"""Is a campaign what its files say? Asked before anything is fitted, answered in sentences."""

from wheelhop.gate.finding import Finding, to_json
from wheelhop.gate.gate import Gated, gate

__all__ = ["Finding", "Gated", "gate", "to_json"]
