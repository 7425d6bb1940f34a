"""`wheelhop flash`: write the firmware into the logger."""

from argparse import Namespace

from wheelhop.logger import plan_upload, upload
from wheelhop.logger.emulated import emulated_ports


def run(arguments: Namespace) -> int:
    """Say what is written where, write it, and verify; raises LoggerError."""
    if arguments.port is None and emulated_ports():
        print("an emulated logger runs: it has its firmware; --port PORT writes to a real one")
        return 0
    plan = plan_upload(arguments.board, arguments.port, arguments.hex, arguments.old_bootloader)
    board = plan.board.title
    print(f"{board} on {plan.port}: writing {plan.firmware} with {plan.tool}", flush=True)
    upload(plan)
    print("written, and read back the same")
    return 0
