"""The seed of a Context: all that is drawn at random follows from it."""

from pydrake.common import RandomGenerator
from pydrake.systems.framework import Context, Diagram

from hunav_drake.scenario.population import people_seed
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.random_streams import check_seed


def DrawSeed(generator: RandomGenerator) -> int:
    """Returns the next seed of a generator, in [0, 2^63)."""
    return int(generator()) << 31 | int(generator()) >> 1


def CheckPeopleSeed(diagram: Diagram, seed: int) -> None:
    """Checks that the people of a trial's diagram are those of a seed.

    Raises:
        ValueError: If they are drawn by the seed of the trial, and the diagram
            was made for another one.
    """
    own = people_seed(diagram.scenario)
    if own not in (None, seed):
        raise ValueError(
            f"the people of this diagram were drawn by seed {own}, so it does"
            f" not serve seed {seed}: make a diagram for each seed, or set"
            " population.seed to have the same people in all trials"
        )


def SetTrialSeed(diagram: Diagram, context: Context, seed: int) -> None:
    """Resets a trial to its start, as drawn from a seed.

    Nothing of the past is kept: the time is 0, and state and parameters are
    those of the default Context, but for what is drawn. It is, bit for bit,
    the Context in which a diagram of the same scenario with that seed starts.
    One diagram serves all seeds:

        simulator = MakeTrialSimulator(diagram)
        for seed in range(100):
            SetTrialSeed(diagram, simulator.get_mutable_context(), seed)
            simulator.Initialize()
            simulator.AdvanceTo(scenario.simulation.duration)

    The people of a population are drawn when the diagram is made. With a
    `population.seed` they are the same for all seeds, which draw when those of
    its sources come; else the diagram serves the seed that it was made for,
    and `RunTrial(scenario, seed)` makes one for each.

    `diagram.SetRandomContext(context, generator)` does this with a seed that it
    draws from the generator. Drake's `MonteCarloSimulation` does not call that,
    but resets what it is given to the start of the diagram's own seed: give it
    `MakeRandomSimulator(scenario)`.

    Args:
        diagram: From `MakeTrialDiagram`.
        context: A Context of it, changed.
        seed: In [0, 2^63).

    Raises:
        ValueError: If the seed is not such a number, or if the people were
            drawn by another one.
        RuntimeError: If the Context is of another diagram.
    """
    check_seed(seed)
    CheckPeopleSeed(diagram, seed)
    diagram.ValidateContext(context)
    diagram.SetDefaultContext(context)
    context.SetTime(0.0)
    crowd = diagram.GetSubsystemByName("humans").GetSubsystemByName("crowd")
    crowd.SetSeed(crowd.GetMyMutableContextFromRoot(context), seed)
    # Sensors with noise.
    for system in diagram.GetSystems():
        if hasattr(system, "SetSeed"):
            system.SetSeed(system.GetMyMutableContextFromRoot(context), seed)
    if diagram.HasSubsystemNamed("plant"):
        # The bodies of people start where the people do.
        from hunav_drake.systems.robot.plant_people import PlacePeople

        plant = diagram.GetSubsystemByName("plant")
        states = diagram.GetOutputPort("human_states").Eval(context)
        PlacePeople(
            plant,
            plant.GetMyMutableContextFromRoot(context),
            states.reshape(-1, STATE_SIZE),
        )


def GetTrialSeed(diagram: Diagram, context: Context) -> int:
    """Returns the seed of a trial: of its diagram, or as `SetTrialSeed` set it.

    Args:
        diagram: From `MakeTrialDiagram`.
        context: A Context of it.
    """
    crowd = diagram.GetSubsystemByName("humans").GetSubsystemByName("crowd")
    seed: int = crowd.GetSeed(crowd.GetMyContextFromRoot(context))
    return seed


def SetHumansSeed(humans: Diagram, context: Context, seed: int) -> None:
    """Resets people to their start, as drawn from a seed.

    They are at rest, with nothing in mind yet. All else stays as it is. For
    people of `AddHumans`, in a Context of the whole diagram:

        humans = diagram.GetSubsystemByName("humans")
        SetHumansSeed(humans, humans.GetMyMutableContextFromRoot(context), 3)

    Args:
        humans: From `MakeHumans` or `AddHumans`.
        context: Its own Context, changed.
        seed: In [0, 2^63).

    Raises:
        ValueError: If the seed is not such a number.
        RuntimeError: If the Context is of another system.
    """
    check_seed(seed)
    humans.ValidateContext(context)
    humans.SetDefaultContext(context)
    crowd = humans.GetSubsystemByName("crowd")
    crowd.SetSeed(humans.GetMutableSubsystemContext(crowd, context), seed)
