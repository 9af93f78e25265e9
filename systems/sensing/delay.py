"""A delay of signals by whole time steps."""

from typing import Any

from pydrake.systems.framework import (
    BasicVector,
    Context,
    Diagram,
    DiagramBuilder,
    DiscreteValues,
    LeafSystem,
    OutputPort,
)

from hunav_drake.systems.common.checks import count_steps


class Delay(LeafSystem):
    """Gives a signal a number of time steps later.

    .. pydrake_system::

        name: Delay
        input_ports:
        - u
        output_ports:
        - delayed_u

    Of port ``u``, a vector, port ``delayed_u`` gives the value of k time steps
    ago. In the first k steps it gives the value of the first one, as if all had
    been at rest before. (Drake's `DiscreteTimeDelay` gives zeros there, which
    would be people at the origin and walls at the lidar.)

    The values are those at time steps: between two of them, it gives what it
    will give at the next one.

    The discrete state holds the last k values; a second group holds the row of
    the oldest one, or -1 before the first update.
    """

    def __init__(
        self,
        size: int,
        delay: float,
        *,
        time_step: float,
        from_zero: bool = False,
    ) -> None:
        """Constructs a Delay of vectors of a size, by `delay` seconds.

        If `from_zero`, the values before the first one are zeros instead, as
        for commands.

        Raises:
            ValueError: If the delay is not a positive multiple of the step.
        """
        super().__init__()
        self._shape = (count_steps(delay, time_step), size)
        self._u = self.DeclareVectorInputPort("u", size)
        self._rows = self.DeclareDiscreteState(self._shape[0] * size)
        self._oldest = self.DeclareDiscreteState([0.0 if from_zero else -1.0])
        self.DeclareVectorOutputPort("delayed_u", size, self._CalcDelayed)
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=time_step, offset_sec=0.0, update=self._Update
        )

    def _Oldest(self, context: Context) -> int:
        return int(context.get_discrete_state(self._oldest).value()[0])

    def _CalcDelayed(self, context: Context, output: BasicVector) -> None:
        oldest = self._Oldest(context)
        rows = context.get_discrete_state(self._rows).value()
        output.SetFromVector(
            self._u.Eval(context)
            if oldest < 0
            else rows.reshape(self._shape)[oldest]
        )

    def _Update(self, context: Context, discrete_state: DiscreteValues) -> None:
        oldest = self._Oldest(context)
        after = discrete_state.get_mutable_value(self._rows)
        after.reshape(self._shape)[slice(None) if oldest < 0 else oldest] = (
            self._u.Eval(context)
        )
        following = (oldest + 1) % self._shape[0]
        discrete_state.set_value(self._oldest, [float(following)])


def AddDelay(
    builder: DiagramBuilder,
    name: str,
    port: OutputPort,
    delay: float,
    time_step: float,
    *,
    from_zero: bool = False,
) -> OutputPort:
    """Returns a port, delayed by a system `name`; itself if not delayed."""
    if not (delay and port.size()):
        return port
    system = Delay(port.size(), delay, time_step=time_step, from_zero=from_zero)
    builder.AddNamedSystem(name, system)
    builder.Connect(port, system.get_input_port())
    return system.get_output_port()


def MakeDelayed(system: Any, delay: float, time_step: float) -> Any:
    """Makes a sensor whose outputs, all vectors, come later.

    Returns:
        A Diagram with the ports of the system; itself if it is not delayed.
    """
    if not delay:
        return system
    builder = DiagramBuilder()
    builder.AddNamedSystem("sensor", system)
    for i in range(system.num_input_ports()):
        port = system.get_input_port(i)
        builder.ExportInput(port, port.get_name())
    for i in range(system.num_output_ports()):
        port = system.get_output_port(i)
        name = port.get_name()
        late = AddDelay(builder, f"delay_{name}", port, delay, time_step)
        builder.ExportOutput(late, name)
    diagram: Diagram = builder.Build()
    return diagram
