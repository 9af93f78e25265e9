"""What systems that draw at random share: samples that are held."""

from collections.abc import Sequence
import math
from typing import Any

from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    OutputPort,
)

from hunav_drake.systems.common.arrays import Array
from hunav_drake.systems.common.checks import check_count, count_steps
from hunav_drake.systems.common.random_streams import (
    check_seed,
    halves_to_seed,
    seed_to_halves,
)


class Sampling:
    """The part of a LeafSystem that takes a sample every period and holds it.

    It is a second base class of such a system.

    A discrete state holds the last sample and the step of it (-1 before the
    first), so that a system with another period can go on from it; a numeric
    parameter holds the seed, in two halves. A sample of the current instant is
    there at once, before the update that stores it. The state is updated every
    time step, for any period, so that all parts of a trial move at the same
    instants.
    """

    # Of the LeafSystem.
    _samples: OutputPort
    DeclareDiscreteState: Any
    DeclareNumericParameter: Any
    DeclarePeriodicDiscreteUpdateEvent: Any
    ValidateContext: Any

    def _DeclareSampling(
        self,
        before: Sequence[float] | Array,
        *,
        period: float,
        time_step: float,
        seed: int,
        number: int,
    ) -> None:
        """Declares state and parameter; `before` is held in the beginning.

        The system has a port `self._samples` with the calculation
        `_CalcSample`.
        """
        # (A diagram has several periods.)
        self._steps_per_sample = count_steps(
            period, time_step, f"{type(self).__name__}: period"
        )
        self._time_step = time_step
        self._number = check_count("number", number)
        self._held = self.DeclareDiscreteState([*before, -1.0])
        self._seed = self.DeclareNumericParameter(
            BasicVector(seed_to_halves(check_seed(seed)))
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def SetSeed(self, context: Context, seed: int) -> None:
        """Sets the seed of draws in a Context; nothing else changes.

        Raises:
            ValueError: If the seed is not in [0, 2^63).
        """
        self.ValidateContext(context)
        halves = seed_to_halves(check_seed(seed))
        context.get_mutable_numeric_parameter(self._seed).SetFromVector(halves)

    def GetSeed(self, context: Context) -> int:
        """Returns the seed of a Context of this system."""
        self.ValidateContext(context)
        parameter = context.get_numeric_parameter(self._seed)
        return halves_to_seed(parameter.CopyToVector())

    def _SampleNumber(self, context: Context) -> int:
        """Returns the number of the latest possible sample, from 0."""
        time: float = context.get_time()
        steps = math.floor(time / self._time_step + 1e-6)
        return steps // self._steps_per_sample

    def _IsDue(self, context: Context, number: int) -> bool:
        """Returns whether a sample of this number is not yet held."""
        held = context.get_discrete_state(self._held).value()
        return bool(held[-1] < number * self._steps_per_sample)

    def _Measure(self, context: Context, held: Array, number: int) -> Array:
        """Returns a sample; `held` are the last one and its step."""
        raise NotImplementedError

    def _CalcSample(self, context: Context, output: BasicVector) -> None:
        held = context.get_discrete_state(self._held).value()
        number = self._SampleNumber(context)
        is_new = self._IsDue(context, number)
        output.SetFromVector(
            self._Measure(context, held, number) if is_new else held[:-1]
        )

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        number = self._SampleNumber(context)
        if self._IsDue(context, number):
            sample = self._samples.Eval(context).tolist()
            step = number * self._steps_per_sample
            discrete_state.set_value(self._held, [*sample, step])
