"""Tables as data loggers write them, with the recording that each of them is of."""

from math import sin

from tests.formats.foreign import save
from wheelhop.formats import ExchangeError, draft_mapping, parse_mapping, read

ROWS = 300
WAVE = [sin(0.2 * k) for k in range(ROWS)]
"""What every table holds; at 100 Hz it lasts 3 s."""


def table(stamp, head="Time,az [g]", rows=ROWS, above="", **more):
    """A text of two columns: the stamps of rows 0, 1, … and `WAVE`."""
    separator = more.get("separator", ",")
    lines = [
        f"{stamp(k)}{separator}{WAVE[k % ROWS]:.4f}{more.get('tail', '')}"
        for k in range(rows)
        if k not in more.get("without", ())
    ]
    return "\n".join([above + head if above or head else lines.pop(0), *lines]) + "\n"


def drafted(tmp_path, text, name="run.csv"):
    """The recording that the draft of a text reads as it is; or the line that says what must be
    answered."""
    path = save(tmp_path, name, text)
    try:
        return read(path, parse_mapping(draft_mapping(path), tmp_path / "map.toml"))
    except ExchangeError as error:
        assert "\n" not in str(error)
        return str(error)


def units_of(recording):
    """Names and units of the channels."""
    return {channel.name: channel.unit for channel in recording.channels}
