"""`wheelhop logger`: ask the logger and set it up over the serial line."""

import sys
from argparse import Namespace

from wheelhop.logger.emulated import emulated_ports
from wheelhop.logger.error import LoggerError
from wheelhop.logger.link import Link, connect
from wheelhop.logger.port import find_ports
from wheelhop.logger.self_test import WORDS, expected_codes, self_test

SETTINGS = (
    *("rate", "channels", "name", "start", "stream", "size_mb", "pulses_per_km"),
    *("device", "calibration", "clock_ppm"),
)


def run(arguments: Namespace) -> int:
    """Do what is said, on one line or several of output; raises LoggerError."""
    settings = [_setting(text) for text in arguments.set]
    if arguments.action == "ports":
        ports = [*find_ports(), *emulated_ports()]
        print("\n".join(ports) or "no serial port over USB")
        return 0
    with connect(arguments.port, baud=arguments.baud) as link:
        for key, value in settings:
            link.set(key, value)
        return _do(arguments.action, link)


def _setting(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals or key not in SETTINGS:
        raise LoggerError(f"--set {text}: write KEY=VALUE, KEY one of {', '.join(SETTINGS)}")
    return key, value


def _do(action: str, link: Link) -> int:
    if action == "info":
        _print({"port": link.port.name, **link.info()})
    elif action == "status":
        _print(link.status())
    elif action == "list":
        _print({name: f"{size} bytes" for name, size in link.files().items()})
    elif action == "time":
        link.set_time()
    elif action == "selftest":
        return _self_test(link)
    elif action == "start":
        print(f"recording {link.start()}")
    elif action == "stop":
        link.stop()
        _print(link.status())
    sys.stdout.flush()
    return 0


def _self_test(link: Link) -> int:
    """Print what every sensor answers; 1 if one of them is not as it should be."""
    answers = self_test(link)
    least, typical, most = expected_codes()
    print(f"expected: {typical:.0f} codes, {least:.0f} to {most:.0f} by the ADXL326's data sheet")
    for one in answers:
        print(
            f"{one.channel:<4} at {one.level:6.1f}  {one.shift:+6.1f} codes  {WORDS[one.verdict]}"
        )
    if all(one.verdict == "dead" for one in answers):
        print("none answers: the logger's D8 does not reach the sensors' ST pins")
    return 0 if all(one.verdict == "moves" for one in answers) else 1


def _print(values: dict[str, str]) -> None:
    width = max((len(key) for key in values), default=0)
    for key, value in values.items():
        print(f"{key:<{width}}  {value}".rstrip())
