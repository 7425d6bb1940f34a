"""`wheelhop demo`: a campaign that comes with wheelhop, copied to where the user can change it."""

import shutil
from argparse import Namespace
from importlib.resources import as_file, files
from pathlib import Path

from wheelhop.cli import check

EXAMPLE = "open-dry-friction"


def run(arguments: Namespace) -> int:
    """Run the demo in the folder the user chose."""
    return run_demo(arguments.folder)


def run_demo(folder: Path) -> int:
    """Copy the example into `folder` and show what it holds."""
    copy_example(folder)
    return check.run(Namespace(campaign=folder))


def copy_example(folder: Path) -> None:
    """Copy the example campaign into `folder`, fresh even if it was there."""
    with as_file(files("wheelhop") / "examples" / EXAMPLE) as example:
        shutil.copytree(example, folder, dirs_exist_ok=True)
