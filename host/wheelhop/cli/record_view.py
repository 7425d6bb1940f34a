"""A recording on the terminal: a bar for each channel and how line and card are doing."""

import sys
import time
from types import TracebackType

import numpy as np
from rich.console import Group, RenderableType
from rich.live import Live as Screen
from rich.table import Table
from rich.text import Text

from wheelhop.cli.output import open_console
from wheelhop.logger.live import CLIPPED, CODES, Live

BAR = 48  # characters, for the converter's range
REFRESH_S = 0.1
PLAIN_S = 5.0
WINDOW_S = 1.0


class View:
    """Shows a recording; where stdout is no terminal, a line every few seconds."""

    def __init__(self) -> None:
        self._console = open_console()
        self._screen: Screen | None = None
        self._shown_s = self._begin_s = time.monotonic()

    def say(self, message: str) -> None:
        """A line that stays."""
        self._console.print(Text(message))

    def show(self, live: Live) -> None:
        """Draw, if it is time to."""
        while live.messages:
            self.say(live.messages.popleft())
        now_s = time.monotonic()
        if now_s - self._shown_s < (REFRESH_S if self._console.is_terminal else PLAIN_S):
            return
        self._shown_s = now_s
        if self._console.is_terminal:
            if self._screen is None:
                self._screen = Screen(
                    console=self._console, auto_refresh=False, redirect_stderr=False
                )
                self._screen.start()
            self._screen.update(picture(live), refresh=True)
        else:
            print(f"{now_s - self._begin_s:.0f} s: {line(live)}")
            sys.stdout.flush()

    def __enter__(self) -> "View":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._screen:
            self._screen.stop()


def line(live: Live) -> str:
    """The state in a line."""
    where = live.file.name if live.file else "no file yet"
    words = [where, f"{live.written} scans, {live.lost} missing"]
    words.append(f"{live.measured_rate_hz():.1f} Hz" if live.connected else "no connection")
    return "; ".join([*words, *_card(live)])


def picture(live: Live) -> RenderableType:
    """The state as a screen."""
    return Group(_title(live), _bars(live), *_facts(live))


def _title(live: Live) -> Text:
    seconds = live.written / live.rate_hz
    file = str(live.file) if live.file else "waiting for scans"
    recording = live.connected and live.session is not None
    text = Text.assemble(("● ", "red" if recording else "dim"), (file, "bold"))
    text.append(f"   {int(seconds // 60)}:{seconds % 60:04.1f}")
    if not live.connected:
        text.append("   no connection", "bold red")
    return text


def _bars(live: Live) -> Table:
    """The range of each channel in the last second, and where it is now."""
    table = Table(box=None, pad_edge=False, show_header=True, header_style="dim")
    table.add_column("", justify="left")
    table.add_column(f"0{'code':^{BAR - 5}}1023", no_wrap=True)
    for heading in ("mean", "sd"):
        table.add_column(heading, justify="right", min_width=6)
    codes = live.window(WINDOW_S)
    for column, name in enumerate(live.channels):
        values = codes[:, column]
        if not len(values):
            table.add_row(name, Text("·" * BAR, "dim"), "", "")
            continue
        style = "red" if values.min() < CLIPPED[0] or values.max() > CLIPPED[1] else "cyan"
        mean, spread = f"{values.mean():.1f}", f"{values.std():.1f}"
        table.add_row(name, _bar(values, style), mean, spread)
    return table


def _bar(values: np.ndarray, style: str) -> Text:
    low, high, now = (int(x * BAR / CODES) for x in (values.min(), values.max(), values[-1]))
    bar = Text()
    for place in range(BAR):
        if place == now:
            bar.append("┃", "bold")
        elif low <= place <= high:
            bar.append("━", style)
        else:
            bar.append("│" if place == BAR // 2 else "·", "dim")
    return bar


def _facts(live: Live) -> list[Text]:
    rate = f"rate   {live.measured_rate_hz():.1f} of {live.rate_hz} scans/s"
    lost = f"missing {live.lost}, broken frames {live.broken}"
    facts = [Text(f"{rate}   {lost}", "red" if live.lost else "")]
    card = _card(live)
    facts.append(Text(f"card   {', '.join(card) if card else live.card or 'not heard of'}"))
    clock = "not known yet"
    if live.clock:
        clock = f"{live.clock.ppm:+.0f} ± {2 * live.clock.deviation_ppm:.0f} ppm"
    supply = f"{live.supply_mv / 1000:.2f} V" if live.supply_mv else "unknown"
    facts.append(Text(f"clock  {clock}   supply {supply}   {live.port}   Ctrl-C ends"))
    return facts


def _card(live: Live) -> list[str]:
    told = live.told
    if told is None:
        return []
    words = [f"{told.written} scans safe", f"{told.lost} lost", f"stall {told.stall_ms} ms"]
    return [*words, *([f"{told.card_errors} card errors"] if told.card_errors else [])]
