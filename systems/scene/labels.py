"""The labels of people in label images."""

# Drake's labels of bodies, their indices, are far below; it reserves those
# above 32765.
_FIRST = 10_000
_MOST = 20_000


def human_label(index: int, first: int = 0) -> int:
    """Returns the label of a person, by index from 0, in label images.

    `first` is the number of people who have labels already.

    Raises:
        ValueError: If there are more people than labels, 20 000.
    """
    if index + first >= _MOST:
        raise ValueError(
            f"a scene has labels for {_MOST} people, got {index + first + 1};"
            " show fewer of them"
        )
    return _FIRST + first + index


def labels_taken(labels: list[int]) -> int:
    """Returns the number of people's labels among all labels of a scene."""
    of_people = [label for label in labels if _FIRST <= label < _FIRST + _MOST]
    return max(of_people, default=_FIRST - 1) + 1 - _FIRST
