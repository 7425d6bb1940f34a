"""`wheelhop info`: everything about a log on one screen."""

from argparse import Namespace
from typing import Any

from wheelhop.cli.output import write_json
from wheelhop.cli.progress import stages
from wheelhop.logger import Log, describe, read_log
from wheelhop.logger.info import warnings


def run(arguments: Namespace) -> int:
    """Describe one log after the other; raises LoggerError."""
    told: list[dict[str, Any]] = []
    for file in arguments.files:
        with stages() as stage:
            like = read_log(arguments.header_from) if arguments.header_from else None
            stage(f"checking {file}")
            log = read_log(
                file,
                header_from=like,
                progress=lambda done, file=file: stage(f"checking {file}: {done:.0%}"),  # type: ignore[misc]
            )
            text = describe(log, lambda done, file=file: stage(f"reading {file}: {done:.0%}"))  # type: ignore[misc]
            told.append(log_to_json(log))
        print(text, flush=True)
    if arguments.json:
        write_json(arguments.json, {"format": 1, "logs": told})
    return 0


def log_to_json(log: Log) -> dict[str, Any]:
    """What there is to know of a log: scans due, written and missing, gaps, damage, settings."""
    return {
        "name": log.name,
        "session": log.session >> 16,
        "closed": log.summary is not None,
        "header": dict(log.header),
        "scans_due": log.due,
        "scans_written": log.written,
        "scans_missing": log.missing,
        "late": log.late,
        "clock_ppm": log.clock_ppm,
        "gaps": [{"first_scan": gap.first, "scans": gap.scans} for gap in log.gaps],
        "warnings": list(warnings(log)),
    }
