"""`wheelhop info`: everything about a log on one screen."""

from argparse import Namespace

from wheelhop.cli.progress import stages
from wheelhop.logger import describe, read_log


def run(arguments: Namespace) -> int:
    """Describe one log after the other; raises LoggerError."""
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
        print(text, flush=True)
    return 0
