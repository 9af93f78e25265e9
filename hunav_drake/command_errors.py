"""What all commands of `hunav` share: exit codes, and bad input."""

from pathlib import Path

# The exit codes.
DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


class InputError(Exception):
    """Something that the caller gave cannot be used; the text says what."""


def check_writable(directory: Path) -> None:
    """Finds out before the work whether its results can be kept.

    Raises:
        InputError: If nothing can be written to the folder.
    """
    import tempfile

    try:
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=directory):
            pass
    except OSError as error:
        raise InputError(
            f"--out {directory}: cannot write there: {error.strerror}. Name a"
            " folder that you may write to."
        ) from error
