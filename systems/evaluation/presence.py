"""How many people are there while a trial runs, and how they come and go."""

import numpy as np
import pandas as pd

from hunav_drake.systems.evaluation.recording import Recording


def count_people(recording: Recording) -> pd.DataFrame:
    """Counts the people of a recording over time.

    Who comes or leaves between two samples is counted at the later one. A
    person who does both in that time is not; `OpenCrowd` keeps people outside
    for a second, so that periods up to that see everybody.

    Returns:
        A row for each sample, indexed by the time, in seconds, with the
        columns "present", the people who are there, and "arrivals" and
        "departures", how many have come and have left since the first sample.
        So present = present at the first sample + arrivals - departures.
    """
    present = recording.features.present
    change = np.diff(present.astype(int), axis=0, prepend=present[:1])
    return pd.DataFrame(
        {
            "present": present.sum(axis=1),
            "arrivals": (change > 0).sum(axis=1).cumsum(),
            "departures": (change < 0).sum(axis=1).cumsum(),
        },
        index=pd.Index(recording.times, name="time"),
    )
