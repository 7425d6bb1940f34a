"""`wheelhop flash`: write the firmware into the logger."""

from argparse import Namespace

from wheelhop.logger import plan_upload, upload


def run(arguments: Namespace) -> int:
    """Say what is written where, write it, and verify; raises LoggerError."""
    plan = plan_upload(arguments.board, arguments.port, arguments.hex, arguments.old_bootloader)
    board = plan.board.title
    print(f"{board} on {plan.port}: writing {plan.firmware} with {plan.tool}", flush=True)
    upload(plan)
    print("written, and read back the same")
    return 0
