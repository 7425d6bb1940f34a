"""What channels and roads can show, on the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from wheelhop.predict.detectable import Detectable
from wheelhop.report.can_show import best_words, seen_from


def print_detectable(found: Detectable, console: Console) -> None:
    """Print from where on effects would be seen, and what one more channel would add; or why
    nothing can be diagnosed."""
    if found.refused:
        console.print(Text(f"! cannot be compared or diagnosed: {found.refused}", style="yellow"))
        return
    console.print("These channels and roads would show, from so much on (to first order):")
    table = Table(box=None, pad_edge=False, show_header=False)
    for effect, words in seen_from(found):
        table.add_row(Text(f"  {effect}"), Text(words))
    console.print(table)
    if words := best_words(found):
        console.print(Text(words))
