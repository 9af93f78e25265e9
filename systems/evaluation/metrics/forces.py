"""The forces of the social force model between robot, people and walls.

They use the constants of HuNavSim's metrics, not those of the simulated people:
k_s = 2.1, lambda = 2, gamma = 0.35, n = 2, n' = 3, no epsilon, k_o = 10,
sigma_o = 0.2. A sum over samples grows with their number, so each has a
companion that does not: its rate.
"""

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.evaluation.features import mean_of_present
from hunav_drake.systems.evaluation.metrics.rates import register_sum_and_rate
from hunav_drake.systems.evaluation.recording import Recording

SOURCE = (
    "social force model, Moussaid et al. 2009, Helbing & Molnar 1995; "
    "HuNavSim, Perez-Higueras et al. 2023"
)

_sum_and_rate = register_sum_and_rate(
    unit="m/s^2", family="forces", source=SOURCE
)


@_sum_and_rate
def social_force_on_agents(recording: Recording) -> Array:
    """The social forces of the robot on people: sum_{k,i} |f_k^{r->i}|.

    0 without people. Series: the sum over people.
    """
    return recording.features.social_force.sum(axis=1)


@_sum_and_rate
def social_force_on_robot(recording: Recording) -> Array:
    """The social forces of people on the robot: sum_{k,i} |f_k^{i->r}|.

    It equals the forces on the people, as the law is antisymmetric. 0 without
    people. Series: the sum over people.
    """
    return recording.features.social_force.sum(axis=1)


@_sum_and_rate
def obstacle_force_on_agents(recording: Recording) -> Array:
    """The forces of the walls on people: sum_k mean_i |f_k^{o->i}|.

    The forces of all walls on one person add up as vectors. A person inside a
    solid is pushed away from the nearest point of its outline, farther in. The
    mean is over the people present; NaN without people, or if the walls are not
    known. Series: that mean.
    """
    return mean_of_present(recording.features.obstacle_force_on_humans)


@_sum_and_rate
def obstacle_force_on_robot(recording: Recording) -> Array:
    """The force of the walls on the robot: sum_k |f_k^{o->r}|.

    The forces of all walls add up as vectors. Inside a solid, the robot is
    pushed away from the nearest point of its outline, farther in. NaN if the
    walls are not known. Series: the force.
    """
    return recording.features.obstacle_force_on_robot


@_sum_and_rate
def social_work(recording: Recording) -> Array:
    """The social work of the robot on itself and on people.

    The sum of the social force on the robot, the obstacle force on the robot,
    and the social forces on people. NaN if the walls are not known. Series:
    that sum at each sample.
    """
    return (
        social_force_on_robot(recording)
        + obstacle_force_on_robot(recording)
        + social_force_on_agents(recording)
    )
