import pytest

from hunav_drake.commands.cli import main


@pytest.fixture
def hunav(capsys):
    """Runs the command in this process: (exit code, output, errors)."""

    def run(*arguments):
        code = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run
