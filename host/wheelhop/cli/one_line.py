"""Mistakes on the command line: each is said in one line."""

import argparse
import re
from typing import NoReturn

BAD_INPUT = 2
NO_CHOICE = re.compile(
    r"argument (?P<what>.*): invalid choice: '(?P<word>.*)' \(choose from (?P<choices>.*)\)"
)
"""As argparse says it."""
NO_OPTION = re.compile(r"unrecognized arguments: (?P<word>--\S+)")


class OneLineParser(argparse.ArgumentParser):
    """Says what is wrong in one line instead of printing the usage first."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong, with what was probably meant, and exit."""
        if match := NO_CHOICE.match(message):
            from wheelhop.files import did_you_mean  # not for who makes no mistake

            choices = match["choices"].replace("'", "")
            near = did_you_mean(match["word"], choices.split(", "))
            message = f"{match['what']}: there is no '{match['word']}'"
            message += near.rstrip("?") or f": choose from {choices}"
        elif match := NO_OPTION.match(message):
            from wheelhop.files import did_you_mean

            message += did_you_mean(match["word"].partition("=")[0], _options(self)).rstrip("?")
        self.exit(BAD_INPUT, f"wheelhop: {message}; see {self.prog} --help\n")


def _options(parser: argparse.ArgumentParser) -> list[str]:
    """All options of a parser and of those below it."""
    found: dict[str, None] = {}
    for action in parser._actions:
        found |= dict.fromkeys(action.option_strings)
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                found |= dict.fromkeys(_options(below))
    return list(found)
