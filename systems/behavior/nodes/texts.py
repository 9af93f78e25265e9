"""Numbers for compiled code of what people say, and of names of places."""

import functools
import hashlib

# The numbers of words that the number of a text can tell.
WORDS = 64


@functools.lru_cache(maxsize=4096)
def text_code(text: str) -> float:
    """Returns the number of a text: whole, above 0, and below 2^33.

    It follows from the text alone, so that trees, and robots, need no common
    table. Its remainder by `WORDS` is the number of words, at most 63. An
    empty text has the number 0.
    """
    if not text:
        return 0.0
    digest = hashlib.sha256(text.encode()).digest()
    words = min(len(text.split()), WORDS - 1)
    # (27 bits of it.)
    bits = int.from_bytes(digest[:4]) >> 5
    return float((bits or 1) * WORDS + words)


def place_code(name: str) -> float:
    """Returns the number by which a leaf finds a place.

    Args:
        name: The name of the place, or its number as a text.
    """
    name = name.strip()
    return -1.0 - float(name) if name.isdecimal() else text_code(name)


def people_code(numbers: str) -> float:
    """Returns the number of a list of people, as "2, 3"; of one, its number."""
    people = people_of(numbers)
    return float(people[0]) if len(people) == 1 else -text_code(f"{people}")


def people_of(numbers: str) -> tuple[int, ...]:
    """Returns the numbers of people in a text."""
    return tuple(map(int, numbers.split(",")))
