"""The seed of a Context, which determines all random draws."""

from collections.abc import Iterator

from pydrake.common import RandomGenerator
from pydrake.systems.framework import Context, Diagram, System

from hunav_drake.scenario.population import people_seed
from hunav_drake.systems.common.layout import STATE_SIZE
from hunav_drake.systems.common.random_streams import check_seed


def DrawSeed(generator: RandomGenerator) -> int:
    """Returns the next seed of a generator, in [0, 2^63)."""
    return int(generator()) << 31 | int(generator()) >> 1


def CheckIsTrial(diagram: Diagram) -> None:
    """Checks that a diagram is that of a trial.

    Raises:
        TypeError: If `MakeTrialDiagram` has not made it.
    """
    if not hasattr(diagram, "scenario"):
        raise TypeError(
            f"the diagram must be from MakeTrialDiagram, got {diagram!r:.80};"
            " for people of AddHumans in your own diagram, see SetHumansSeed,"
            " SaveContext and the methods of HumanPorts.crowd"
        )


def CheckPeopleSeed(diagram: Diagram, seed: int) -> None:
    """Checks that the people of a trial's diagram are those of a seed.

    Raises:
        TypeError: If it is not the diagram of a trial.
        ValueError: If the seed of the trial draws the people, and the diagram
            was made for another seed.
    """
    CheckIsTrial(diagram)
    own = people_seed(diagram.scenario)
    if own not in (None, seed):
        raise ValueError(
            f"the people of this diagram were drawn by seed {own}, so it does"
            f" not serve seed {seed}: make a diagram for each seed, or set"
            " population.seed to have the same people in all trials"
        )


def SetTrialSeed(diagram: Diagram, context: Context, seed: int) -> None:
    """Resets a trial to its start, with the draws of a seed.

    The time becomes 0; state and parameters become those of the default
    Context, except for the draws. The result equals, bit for bit, the default
    Context of a diagram of the same scenario with that seed. One diagram serves
    all seeds:

        simulator = MakeTrialSimulator(diagram)
        for seed in range(100):
            SetTrialSeed(diagram, simulator.get_mutable_context(), seed)
            simulator.Initialize()
            simulator.AdvanceTo(scenario.simulation.duration)

    The people of a population are drawn when the diagram is made. With a
    `population.seed` they are the same for all seeds, which then draw the
    arrival times at sources only. Without, the diagram serves only the seed
    that it was made for, and `RunTrial(scenario, seed)` makes one for each.

    `diagram.SetRandomContext(context, generator)` does the same with a seed
    drawn from the generator. Drake's `MonteCarloSimulation` does not call it,
    but resets Contexts to the diagram's own seed: use
    `MakeRandomSimulator(scenario)` there.

    Args:
        diagram: From `MakeTrialDiagram`.
        context: A Context of it, changed.
        seed: In [0, 2^63).

    Raises:
        ValueError: If the seed is not such a number, or if the people were
            drawn by another seed.
        RuntimeError: If the Context belongs to another diagram.
    """
    check_seed(seed)
    CheckPeopleSeed(diagram, seed)
    diagram.ValidateContext(context)
    diagram.SetDefaultContext(context)
    context.SetTime(0.0)
    # The crowd, and what has noise.
    for system in SeededSystems(diagram):
        system.SetSeed(system.GetMyMutableContextFromRoot(context), seed)
    if diagram.HasSubsystemNamed("plant"):
        # The bodies of people start at the same places.
        from hunav_drake.systems.robot.plant_people import PlacePeople

        plant = diagram.GetSubsystemByName("plant")
        for system in diagram.GetSystems():
            if system.HasOutputPort("desired_people_state"):
                own = system.GetMyContextFromRoot(context)
                states = system.GetInputPort("human_states").Eval(own)
                PlacePeople(
                    plant,
                    plant.GetMyMutableContextFromRoot(context),
                    states.reshape(-1, STATE_SIZE),
                )


def SeededSystems(diagram: Diagram) -> Iterator[System]:
    """Yields the systems with a seed, in the order of the diagram."""
    for system in diagram.GetSystems():
        if hasattr(system, "SetSeed"):
            yield system
        elif isinstance(system, Diagram):
            yield from SeededSystems(system)


def SetDecisionSeed(diagram: Diagram, context: Context, seed: int) -> None:
    """Lets people decide by another seed from now on.

    Until their next decision the trial goes on as before, bit for bit; from
    then on it is another one, and the same each time with the same seed. So a
    clone of a Context is one of many futures. Nothing else changes, also not
    the seed that `GetTrialSeed` returns.

    Args:
        diagram: From `MakeTrialDiagram`, of a scenario with `crowd.decisions`.
        context: A Context of it, changed.
        seed: In [0, 2^63).

    Raises:
        TypeError: If it is not the diagram of a trial.
        ValueError: If the seed is not such a number, or if people decide by
            their behaviors alone.
        RuntimeError: If the Context belongs to another diagram.
    """
    CheckIsTrial(diagram)
    humans = diagram.GetSubsystemByName("humans")
    if not humans.HasSubsystemNamed("decisions"):
        raise ValueError(
            "people of this diagram draw no decisions: set crowd.decisions={}"
            " in its scenario"
        )
    diagram.ValidateContext(context)
    system = humans.GetSubsystemByName("decisions")
    system.SetSeed(system.GetMyMutableContextFromRoot(context), seed)


def GetTrialSeed(diagram: Diagram, context: Context) -> int:
    """Returns the seed of a Context of a trial's diagram.

    It is the seed of the scenario, or that of the last `SetTrialSeed`.

    Raises:
        TypeError: If it is not the diagram of a trial.
    """
    CheckIsTrial(diagram)
    crowd = diagram.GetSubsystemByName("humans").GetSubsystemByName("crowd")
    seed: int = crowd.GetSeed(crowd.GetMyContextFromRoot(context))
    return seed


def SetHumansSeed(humans: Diagram, context: Context, seed: int) -> None:
    """Resets people to their start, with the draws of a seed.

    They are at rest, and their behavior trees start anew. All else is
    unchanged. For people of `AddHumans`, in a Context of the whole diagram:

        humans = diagram.GetSubsystemByName("humans")
        SetHumansSeed(humans, humans.GetMyMutableContextFromRoot(context), 3)

    Args:
        humans: From `MakeHumans` or `AddHumans`.
        context: Its own Context, changed.
        seed: In [0, 2^63).

    Raises:
        ValueError: If the seed is not such a number, or the diagram is not one
            of people.
        RuntimeError: If the Context belongs to another system.
    """
    check_seed(seed)
    parts = humans.GetSystems() if hasattr(humans, "GetSystems") else ()
    if not any(
        it.get_name() == "crowd" and hasattr(it, "SetSeed") for it in parts
    ):
        raise ValueError(
            f"{humans.GetSystemPathname()} is not a diagram of people; take the"
            " one that AddHumans has added, as by"
            ' diagram.GetSubsystemByName("humans"), and its own Context'
        )
    humans.ValidateContext(context)
    humans.SetDefaultContext(context)
    for system in SeededSystems(humans):
        system.SetSeed(humans.GetMutableSubsystemContext(system, context), seed)
