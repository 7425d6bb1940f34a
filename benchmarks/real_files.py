"""What becomes of recordings that others have published?

    python -m benchmarks.real_files FOLDER [--markdown]

The files are listed in real_files.toml, with the commit they are from; put them into
FOLDER/OWNER+NAME/FILE. Each is understood as `wheelhop import` does, asked what it does not say,
answered where the list has an answer, and read. A file is right if rate, unit and first sample of a
channel are those that the list knows; those of the text files were read off them by eye, those of
the packed ones by other libraries. Ends with status 1 if a file is silently wrong.
"""

from __future__ import annotations

import argparse
import math
import sys
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

from wheelhop.files import InputError
from wheelhop.formats import is_foreign, read, understand
from wheelhop.logger.recording import Recording

LIST = Path(__file__).with_name("real_files.toml")
CLOSE = 1e-6  # of a sample; single precision
SHORT = 88  # characters of a reason


def outcome(path: Path, known: dict[str, Any]) -> tuple[str, str]:
    """What became of a file, in a word and in a few."""
    answers = known.get("answers", {})
    try:
        asked = [question.key for question in understand(path).questions]
        found = understand(path, answers)
        if found.questions:
            return _as_known("asked", known), "; ".join(q.words for q in found.questions)
        wanted = is_foreign(path) or answers
        recording = read(path, found.mapping() if wanted else None)
    except InputError as error:
        words = str(error).replace(f"{path}: ", "").replace(str(path.parent), "")
        return _as_known("refused", known, words), words
    given = ", ".join(f"{key} = {value}" for key, value in answers.items())
    told = f" with {given}" if given else ""
    about = f"{len(recording.channels)} channels at {recording.rate_hz:g} Hz{told}"
    if wrong := _wrong(recording, known):
        return "WRONG", f"{about}: {wrong}"
    return ("right, asked" if asked or answers else "right"), about


def _as_known(what: str, known: dict[str, Any], words: str = "") -> str:
    return (
        what if what in known and (what == "asked" or known[what] in words) else f"{what}, not due"
    )


def _wrong(recording: Recording, known: dict[str, Any]) -> str:
    """What is not as it is known, "" if nothing is."""
    if not math.isclose(recording.rate_hz, known.get("rate_hz", 0.0), rel_tol=1e-3):
        return f"the rate is {known.get('rate_hz', 'to be asked')}"
    if "channel" not in known:
        return ""
    names = [channel.name for channel in recording.channels]
    if known["channel"] not in names:
        return f"no channel {known['channel']}"
    k = names.index(known["channel"])
    if recording.channels[k].unit != known["unit"]:
        return f"{names[k]} is in {known['unit'] or 'an unknown unit'}"
    first = float(recording.values[0, k])
    if "first" in known and not math.isclose(first, known["first"], rel_tol=1e-5, abs_tol=CLOSE):
        return f"{names[k]} begins with {known['first']:g}, not {first:g}"
    return ""


def main() -> None:
    """Print a line a file, and how many came out how."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--markdown", action="store_true", help="as a table for docs")
    arguments = parser.parse_args()
    count: Counter[str] = Counter()
    if arguments.markdown:
        print("| repository | file | came out | as |\n| --- | --- | --- | --- |")
    for repository in tomllib.loads(LIST.read_text(encoding="utf-8"))["repository"]:
        name = repository["name"]
        for known in repository["file"]:
            file = Path(known["path"]).name
            path = arguments.folder / name.replace("/", "+") / file
            what, words = outcome(path, known) if path.is_file() else ("not there", "")
            count[what] += 1
            words = f"{words[:SHORT]}…" if len(words) > SHORT else words
            if arguments.markdown:
                print(f"| {name} | `{file}` | {what} | {words.replace('|', '/')} |")
            else:
                print(f"{what:16}{name}: {file}: {words}", flush=True)
    print("\n" + ", ".join(f"{number} {what}" for what, number in count.most_common()))
    sys.exit(1 if count["WRONG"] else 0)


if __name__ == "__main__":
    main()
