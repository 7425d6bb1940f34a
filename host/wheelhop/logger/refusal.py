"""What the logger means by a refusal: it has no room for the words."""

WRONG_VALUE = "wrong value"
MEANINGS = {
    "set rate": "rate must be 100, 200 or 400",
    "set channels": "channels: 8 names or -",
    "set name": "name: at most 15 characters",
    "set start": "start: button or power",
    "set stream": "stream: on or off",
    "set resume": "resume: on or off",
    "set size_mb": "size_mb must be 1 to 4095",
    "set pulses_per_km": "pulses_per_km must be 0 to 1000000",
    "set device": "device must be 0 to 65534",
    "set calibration": "calibration: at most 15 characters",
    "set clock_ppm": "clock_ppm must be -20000 to 20000",
    "time": "time: seconds since 1970",
    "get": "write get NAME BLOCK COUNT",
}
"""By the words that a command begins with, of a value that the logger does not take."""


def explain(line: str, refusal: str) -> str:
    """Return the reason for which a command was refused, in words that help its author."""
    if refusal != WRONG_VALUE:
        return refusal  # also that of a firmware which has the words itself
    words = line.partition("=")[0].split()
    return MEANINGS.get(" ".join(words), MEANINGS.get(words[0], refusal))
