"""Settings for every test."""

import os

# Tests run beside each other: one thread of linear algebra each, before numpy is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings

# On slow machines how long one example takes says nothing.
settings.register_profile("wheelhop", deadline=None)
settings.load_profile("wheelhop")

COMPLETE = "WHEELHOP_COMPLETE" in os.environ  # this machine has all that any test needs
ON_REQUEST = "set WHEELHOP_"  # how the reason begins for which a test waits to be asked for


def _missed(report):
    """Where nothing may be missing, a skipped test is a failed one."""
    if COMPLETE and report.skipped and not hasattr(report, "wasxfail"):
        reason = report.longrepr[-1] if isinstance(report.longrepr, tuple) else report.longrepr
        if ON_REQUEST not in str(reason):
            report.outcome, report.longrepr = "failed", f"WHEELHOP_COMPLETE is set, but {reason}"
    return report


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    return _missed((yield))


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    return _missed((yield))
