"""The free walking speed of people, by age and sex.

The mean speed by age is the curve of the RiMEA guideline (figure "walking speed
by age", after Weidmann). The guideline prints the bands that it runs through:
0.58 to 1.61 m/s under 30 years, 1.41 to 1.54 from 30 to 50, 0.68 to 1.41 above.
The ages of these values, and the speeds at 10, 40, 60 and 70 years, are read
off the figure, to about 0.02 m/s.

Over all ages, men walk at 1.41 m/s, women at 1.27, and everybody at 1.34 with a
deviation of 0.26 m/s (Weidmann, Transporttechnik der Fussgaenger, ETH Zuerich,
IVT 90, 1993). These set the ratio of the sexes and, as a part of the mean, the
deviation at every age.
"""

import numpy as np
from numpy.typing import ArrayLike

from hunav_drake.systems.common.arrays import Array

# Ages, in years, and the mean speeds of all people of that age, in m/s.
AGES = (3.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0)
MEAN_SPEEDS = (0.58, 1.17, 1.61, 1.54, 1.48, 1.41, 1.26, 1.06, 0.68)

# Over all ages, in m/s.
MEAN_SPEED = 1.34
SPEED_DEVIATION = 0.26
MEAN_SPEED_OF_MEN = 1.41
MEAN_SPEED_OF_WOMEN = 1.27

# The largest distance from the mean, in deviations.
MAX_DEVIATIONS = 3.0


def mean_walking_speed(age: ArrayLike, is_woman: ArrayLike) -> Array:
    """Returns the mean speed of people of an age and sex, in m/s.

    Args:
        age: In years, any shape. Younger than 3 counts as 3, older than 80 as
            80.
        is_woman: Booleans, of a shape that fits.
    """
    sex = np.where(is_woman, MEAN_SPEED_OF_WOMEN, MEAN_SPEED_OF_MEN)
    years = np.asarray(age, dtype=float)
    return np.asarray(np.interp(years, AGES, MEAN_SPEEDS) * sex / MEAN_SPEED)


def walking_speed_deviation(mean: ArrayLike) -> Array:
    """Returns the deviation of the speeds with a mean, both in m/s."""
    return np.asarray(mean, dtype=float) * (SPEED_DEVIATION / MEAN_SPEED)


def normal_quantiles(
    probabilities: ArrayLike, mean: ArrayLike, deviation: ArrayLike
) -> Array:
    """Returns quantiles of normal distributions cut off on both sides.

    No quantile is farther from the mean than `MAX_DEVIATIONS` deviations; the
    deviation is that of the distribution before it is cut off.

    Args:
        probabilities: In [0, 1], any shape.
        mean: Of a shape that fits.
        deviation: At least 0, of a shape that fits.
    """
    # Imported here, so that a scenario can be read without loading SciPy.
    from scipy.special import ndtr, ndtri

    low = ndtr(-MAX_DEVIATIONS)
    p = low + np.asarray(probabilities, dtype=float) * (1.0 - 2.0 * low)
    return np.asarray(mean + np.asarray(deviation) * ndtri(p))
