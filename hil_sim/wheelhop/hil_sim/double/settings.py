"""What can be set, and how mistakes are answered, as the firmware does it."""

import re
from dataclasses import dataclass, replace

from wheelhop.hil_sim.double.kind import IN_TURN, Kind

RATES = ("100", "200", "400")
DEFAULT_CHANNELS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
LARGEST_PPM = 20_000
LARGEST_DEVICE = 65_534
LARGEST_TIME = 0xFFFF_FFFF
LONGEST_TEXT = 15
WRONG_VALUE = "wrong value"


class Refusal(Exception):
    """The text of an `E`."""


@dataclass(frozen=True)
class Settings:
    """The settings; those of the second line are kept without power."""

    rate_hz: int = 100
    channels: tuple[str, ...] = DEFAULT_CHANNELS
    name: str = ""
    start: str = "button"
    stream: bool = False
    size_mb: int = 128
    resume: bool = True

    device: int = 0
    calibration: str = ""
    clock_ppm: int | None = None
    kind: Kind = IN_TURN

    @property
    def conversions(self) -> int:
        """Of each input in a scan."""
        return self.kind.conversions_hz // self.rate_hz

    @property
    def recorded(self) -> list[int]:
        """The inputs that are recorded."""
        return [k for k, name in enumerate(self.channels) if name != "-"]

    def after_reset(self) -> "Settings":
        """What is left of them."""
        kept = {key: getattr(self, key) for key in ("device", "calibration", "clock_ppm", "kind")}
        return Settings(**kept)

    def apply(self, line: str, running: bool) -> "Settings":
        """The settings after `set LINE`. Raises Refusal, then nothing has changed."""
        key, equals, value = line.partition("=")
        key, value = key.strip(" "), value.strip(" ")
        if not equals:
            raise Refusal("write KEY = VALUE")
        if key == "clock_ppm":
            negative = value.startswith("-")
            size = number(value[negative:], LARGEST_PPM)
            if size is None:
                raise Refusal(WRONG_VALUE)
            return replace(self, clock_ppm=-size if negative else size)
        if running:
            raise Refusal("not during a session")
        if key not in _CHECKS:
            raise Refusal("unknown key")
        return _CHECKS[key](self, value)


def number(text: str, most: int) -> int | None:
    """A decimal number up to `most`, None for anything else."""
    if not re.fullmatch("[0-9]+", text) or int(text) > most:
        return None
    return int(text)


def _rate(settings: Settings, value: str) -> Settings:
    rate = number(value, 400)
    if rate is None or str(rate) not in RATES:
        raise Refusal(WRONG_VALUE)
    return replace(settings, rate_hz=rate)


def _channels(settings: Settings, value: str) -> Settings:
    words = value.split(" ")
    words = [word for word in words if word]
    used = [word for word in words if word != "-"]
    plain = all(re.fullmatch("[0-9A-Za-z_]{1,4}", word) for word in used)
    if len(words) != 8 or not used or not plain or len(set(used)) < len(used):
        raise Refusal(WRONG_VALUE)
    return replace(settings, channels=tuple(words))


def _text(settings: Settings, key: str, value: str) -> Settings:
    if len(value) > LONGEST_TEXT:
        raise Refusal(WRONG_VALUE)
    return replace(settings, **{key: value})  # type: ignore[arg-type]


def _device(settings: Settings, value: str) -> Settings:
    device = number(value, LARGEST_DEVICE)
    if device is None:
        raise Refusal(WRONG_VALUE)
    return replace(settings, device=device)


def _start(settings: Settings, value: str) -> Settings:
    if value not in ("button", "power"):
        raise Refusal(WRONG_VALUE)
    return replace(settings, start=value)


def _stream(settings: Settings, value: str) -> Settings:
    if value not in ("on", "off"):
        raise Refusal(WRONG_VALUE)
    return replace(settings, stream=value == "on")


def _resume(settings: Settings, value: str) -> Settings:
    if value not in ("on", "off"):
        raise Refusal(WRONG_VALUE)
    return replace(settings, resume=value == "on")


def _size(settings: Settings, value: str) -> Settings:
    size = number(value, 4095)
    if not size:
        raise Refusal(WRONG_VALUE)
    return replace(settings, size_mb=size)


_CHECKS = {
    "rate": _rate,
    "channels": _channels,
    "name": lambda settings, value: _text(settings, "name", value),
    "calibration": lambda settings, value: _text(settings, "calibration", value),
    "device": _device,
    "start": _start,
    "stream": _stream,
    "size_mb": _size,
    "resume": _resume,
}
