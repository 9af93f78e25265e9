"""Physical contacts between robot and people.

These are contacts of bodies, reported at every step by the system that moves
the robot (see `layout.Contact`). Those of the family "collisions" are counted
from the samples, with the discs that people and robots keep free.
"""

from functools import partial

import numpy as np

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.layout import Contact
from hunav_drake.systems.evaluation.metric import register_metric
from hunav_drake.systems.evaluation.metrics.goal import SEAN
from hunav_drake.systems.evaluation.recording import Recording

HUNAV_DRAKE = "hunav_drake"

_metric = partial(register_metric, family="contacts", direction="lower")


def _forces(recording: Recording) -> Array | None:
    """Returns the rows of contacts if their forces are known."""
    return recording.contacts if recording.contact_forces_known else None


def _nothing(recording: Recording) -> tuple[float, Array]:
    return np.nan, np.full(len(recording), np.nan)


@_metric(unit="N", source=HUNAV_DRAKE)
def max_contact_force(recording: Recording) -> tuple[float, Array]:
    """The largest horizontal force between the robot and a person.

    It is the maximum over all simulation steps, not only the samples, of the
    mean force in a step; 0 without contact, NaN where forces are not computed,
    as for kinematic robots. Series: the largest force on a person in the step
    before each sample.
    """
    contacts = _forces(recording)
    if contacts is None:
        return _nothing(recording)
    peaks = _peaks(contacts)
    return float(peaks.max(initial=0.0)), _now(contacts).max(axis=1, initial=0)


def largest_forces(recording: Recording) -> Array:
    """Returns the largest force since the sample before, (samples,).

    A peak between two samples is known if it is larger than all before.
    """
    contacts = _forces(recording)
    if contacts is None:
        return np.full(len(recording), np.nan)
    peaks = _peaks(contacts)
    is_new = np.diff(peaks, axis=0, prepend=0) > 0
    forces = np.where(is_new, peaks, _now(contacts))
    return forces.max(axis=1, initial=0.0)


def _peaks(contacts: Array) -> Array:
    """Returns the peak forces until each sample, (samples, people)."""
    impulse = contacts[..., Contact.IMPULSE]
    # Without contacts that ended before the recording began, where peaks are
    # those of single contacts.
    counts = (impulse > impulse[0]) | (contacts[0, :, Contact.LASTS] > 0)
    return np.where(counts, contacts[..., Contact.PEAK_FORCE], 0.0)


def _now(contacts: Array) -> Array:
    """Returns the forces at each sample, (samples, people)."""
    return np.hypot(
        contacts[..., Contact.FORCE_X], contacts[..., Contact.FORCE_Y]
    )


@_metric(unit="N*s", source=HUNAV_DRAKE)
def contact_impulse(recording: Recording) -> tuple[float, Array]:
    """The impulse of all contacts with people: the sum of int |F_i| dt.

    The integral is over all simulation steps; 0 without contact, NaN where
    forces are not computed. Series: the impulse up to each sample.
    """
    contacts = _forces(recording)
    if contacts is None:
        return _nothing(recording)
    impulse = contacts[..., Contact.IMPULSE]
    series = (impulse - impulse[0]).sum(axis=1)
    return float(series[-1]), series


def _begun(recording: Recording, column: Contact) -> tuple[float, Array]:
    if recording.contacts is None:
        return _nothing(recording)
    count = recording.contacts[..., column]
    series = (count - count[0]).sum(axis=1)
    return float(series[-1]), series


@_metric(unit="-", source=HUNAV_DRAKE)
def contacts_with_walls(recording: Recording) -> tuple[float, Array]:
    """The number of times that the robot ran into walls.

    A contact begins where a wall stops the robot's disc, or would if walls
    stopped it. It ends when the wall has not done so, and has been 0.02 m away,
    for 0.25 s. NaN where contacts with walls are not recorded. Series: the
    number of contacts begun by each sample.
    """
    if recording.wall_contact is None:
        return _nothing(recording)
    count = recording.wall_contact[:, Contact.BY_ROBOT]
    series = count - count[0]
    return float(series[-1]), series


for _who, _other, _column in (
    ("robot", "person", Contact.BY_ROBOT),
    ("person", "robot", Contact.BY_PERSON),
):
    register_metric(
        name=f"contacts_by_{_who}",
        unit="-",
        family="contacts",
        direction="lower",
        source=SEAN,
        definition=f"""
            The number of times that the {_who} ran into the {_other}.

            A contact begins where the bodies touch, or would if they were not
            kept apart, and ends when they have not touched for 0.25 s. With n
            the unit vector from robot to person, just before it the robot
            approaches at a = max(v_r . n, 0) and the person at b = max(-v_i .
            n, 0). It is attributed to the faster one, and to both if they are
            equal within 1e-6 m/s. NaN where contacts are not recorded. Series:
            the number of contacts begun by each sample. """,
    )(partial(_begun, column=_column))
