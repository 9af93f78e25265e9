"""Obstacles that another simulator tells people one by one.

In HuNavSim, each agent of a request brings the points of obstacles near it,
`closest_obs`: it feels these, and no others.
"""

from collections.abc import Sequence
import dataclasses as dc
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Context, Diagram

from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.schema import MAX_COORDINATE
from hunav_drake.systems.crowd import CrowdConfig, HumanCrowd
from hunav_drake.systems.people import HumanConfig
from hunav_drake.systems.people.names import name_people
from hunav_drake.systems.people.profile import complete_people
from hunav_drake.systems.world.obstacles import Obstacles

Array = NDArray[np.float64]


class PeopleAtPoints:
    """Steps of people who feel given points instead of the walls.

    All of a person's points push, however far they are; the walls do not, nor
    do they lead the person around or stop the person. What hides the robot
    from people are still the walls.
    """

    def __init__(
        self,
        diagram: Diagram,
        humans: Sequence[HumanConfig],
        *,
        config: CrowdConfig | None,
        num_robots: int,
        time_step: float,
    ) -> None:
        """Takes a diagram of `MakeHumans` and what it was made of."""
        config = config or CrowdConfig()
        self._crowd = diagram.GetSubsystemByName("crowd")
        self._humans = complete_people(name_people(humans), config.profile)
        self._options: dict[str, Any] = {
            "config": dc.replace(
                config,
                obstacle_range=MAX_COORDINATE,
                max_obstacles=0,
                keep_out_of_walls=False,
                route_planning=False,
            ),
            "num_robots": num_robots,
            "time_step": time_step,
        }

    def CalcNext(
        self, context: Context, points: Sequence[Array | None]
    ) -> dict[int, Array]:
        """Returns the rows of those people one step later who have points.

        Args:
            context: Of the diagram; it is not changed.
            points: As `read_closest_obs` gives them.

        Returns:
            By the indices of these people, (x, y, yaw, vx, vy, omega, radius).
        """
        return {
            index: self._Step(context, index, own)
            for index, own in enumerate(points)
            if own is not None
        }

    def _Step(self, root: Context, index: int, points: Array) -> Array:
        """Returns the row of a person, if the world was made of points."""
        crowd = HumanCrowd(
            self._humans,
            obstacles=Obstacles.from_points(points),
            **self._options,
        )
        given = self._crowd.GetMyContextFromRoot(root)
        own = crowd.CreateDefaultContext()
        own.get_mutable_discrete_state().SetFrom(given.get_discrete_state())
        crowd.SetWeights(own, self._crowd.GetWeights(given))
        for port in range(crowd.num_input_ports()):
            value = self._crowd.get_input_port(port).Eval(given)
            crowd.get_input_port(port).FixValue(own, value)
        own.SetDiscreteState(crowd.EvalUniquePeriodicDiscreteUpdate(own))
        states = crowd.get_human_states_output_port().Eval(own)
        row: Array = states.reshape(-1, STATE_SIZE)[index].copy()
        return row
