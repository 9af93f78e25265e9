"""Halls at whose doors people come and go."""

import numpy as np

from hunav_drake import LoadScenario, MakeTrialDiagram, Scenario
from hunav_drake.systems.common.layout import STATE_SIZE

# People cross a hall of 12 m by 8 m, from west to east and back.
STATION = """\
name: station
world:
  walls:
    - {type: box, center: [6, 4.1], size: [12.4, 0.2]}
    - {type: box, center: [6, -4.1], size: [12.4, 0.2]}
robot: {start: [6, -3.4, 1.57], goal: [6, 3.4, 1.57]}
simulation: {duration: 20.0}
population:
  seed: 3
  sources:
    - name: west
      start: [{rectangle: [0.2, 0, 1, 3]}]
      rate: 0.8
      max_present: 14
      sinks: {east: 1}
      group_sizes: [2, 1, 1]
      behaviors: {regular: 2, curious: 1}
    - name: east
      start: [{rectangle: [11, -3, 11.8, 0]}]
      rate: 0.5
      max_present: 12
      sinks: {west: 1}
  sinks:
    - {name: west, area: {rectangle: [0, -3, 0.3, 0]}}
    - {name: east, area: {rectangle: [11.7, 0, 12, 3]}}
"""


def station(*overrides: str) -> Scenario:
    """Returns the station, with settings."""
    return LoadScenario(data=STATION, overrides=overrides)


def make(*overrides: str):
    """Returns its diagram."""
    return MakeTrialDiagram(station(*overrides))


def crowd_of(diagram, context):
    """Returns the crowd of a trial, and its own Context."""
    crowd = diagram.GetSubsystemByName("humans").GetSubsystemByName("crowd")
    return crowd, crowd.GetMyContextFromRoot(context)


def counts_of(diagram, context):
    """Returns how many people have come and gone."""
    crowd, own = crowd_of(diagram, context)
    return crowd.GetCounts(own)


def rows_of(diagram, context) -> np.ndarray:
    """Returns the rows of `human_states`."""
    port = diagram.GetOutputPort("human_states")
    return port.Eval(context).reshape(-1, STATE_SIZE)
