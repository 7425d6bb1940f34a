"""How `pio test -e native` reads what the programs in this folder print."""

import click
from platformio.public import TestCase, TestRunnerBase, TestStatus


class CustomTestRunner(TestRunnerBase):
    """Takes lines `name:PASSED` and `name:FAILED`; what else is printed is shown."""

    def on_testing_line_output(self, line):
        """Called for every line of a test program."""
        name, _, status = line.strip().rpartition(":")
        if status in ("PASSED", "FAILED"):
            case = TestCase(name=name, status=TestStatus.from_string(status))
            self.test_suite.add_case(case)
        click.echo(line, nl=False)
