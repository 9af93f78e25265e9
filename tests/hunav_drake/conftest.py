import re

import pytest

from hunav_drake.commands.cli import main


@pytest.fixture
def hunav(capsys):
    """Runs the command in this process: (exit code, output, errors)."""

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        # The first run on a machine tells that it compiles.
        errors = re.sub(r"(?m)^Compil(ed|ing) .*\n", "", captured.err)
        return code, captured.out, errors

    return run
