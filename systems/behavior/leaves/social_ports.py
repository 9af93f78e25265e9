"""Types of ports that name people, places and results, and durations."""

import re
from typing import Annotated

from pydantic import AfterValidator

from hunav_drake.systems.behavior.nodes.port import Meaning
from hunav_drake.systems.common.schema import fault, within

_PEOPLE = re.compile(r"\s*\d{1,10}(\s*,\s*\d{1,10})*\s*")


def _people(text: str) -> str:
    if not _PEOPLE.fullmatch(text):
        raise fault("must be numbers of people, as in 2, 3")
    return text


# The number of a person; -1 is nobody, or everybody, or oneself.
PersonNumber = Annotated[int, within(-1, 2**31 - 1), Meaning.PERSON]
NOBODY = -1

# Numbers of people, as "2, 3".
People = Annotated[str, AfterValidator(_people), Meaning.PEOPLE]

# The name or the number of a place, and of one that is a door.
PlaceName = Annotated[str, Meaning.PLACE]
DoorName = Annotated[str, Meaning.DOOR]

# The name of a need of the person.
NeedName = Annotated[str, Meaning.NEED]

# An entry of the blackboard that the leaf sets.
Result = Annotated[int, Meaning.RESULT]
NO_RESULT = -1

Seconds = Annotated[float, within(0, 1e9, "s")]
