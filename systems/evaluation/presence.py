"""The number of people in a trial over time, with arrivals and departures."""

import numpy as np
import pandas as pd

from hunav_drake.systems.evaluation.recording import Recording


def count_people(recording: Recording) -> pd.DataFrame:
    """Counts the people of a recording over time.

    Arrivals and departures between two samples count at the later one. A person
    who leaves and returns between them is not counted; `OpenCrowd` keeps people
    outside for a second, so sample periods up to that count everybody.

    Returns:
        A row per sample, indexed by the time, in seconds, with the columns
        "present", the number of people, and "arrivals" and "departures", their
        numbers since the first sample. So present = present at the first sample
        + arrivals - departures.
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
