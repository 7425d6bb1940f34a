"""Which board the double is: what `firmware/lib/board/traits.h` says of a board in numbers."""

from dataclasses import dataclass

from wheelhop.logger.block import MAGIC, MAGIC_2, SUM_BITS
from wheelhop.logger.settings import CODE_BITS, TOGETHER


@dataclass(frozen=True)
class Kind:
    """Format of its logs, bits of sums and codes, conversions of each input a second, and whether
    it converts all inputs at the same instant."""

    magic: bytes = MAGIC
    sum_bits: int = SUM_BITS
    code_bits: int = CODE_BITS
    conversions_hz: int = 800
    together: bool = False

    @property
    def header(self) -> dict[str, object]:
        """Lines of the header that only such a board has."""
        if not self.together:
            return {}
        bits = {"sum_bits": self.sum_bits, "code_bits": self.code_bits}
        return {"order": TOGETHER, **bits, "conversions_hz": self.conversions_hz}


IN_TURN = Kind()
ALL_AT_ONCE = Kind(MAGIC_2, 22, 16, 6400, True)
