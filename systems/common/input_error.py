"""The error of unusable input, for users in a terminal."""

# The longest line of a message: an input may be a whole file.
_LONGEST = 2000


def cut(text: str) -> str:
    """Returns a message with lines cut to a readable length."""
    return "\n".join(
        line
        if len(line) <= _LONGEST
        else f"{line[:_LONGEST]}... ({len(line) - _LONGEST} letters more)"
        for line in text.split("\n")
    )


class InputError(Exception):
    """The input of the user cannot be used; the text says why."""

    def __init__(self, text: str) -> None:
        """Constructs an error of this text."""
        super().__init__(cut(text))
