"""The messages of a ROS bag, read one by one."""

from collections.abc import Iterator
import contextlib
from itertools import islice
from typing import Any

from hunav_drake.systems.evaluation.recording_checks import LARGEST
from hunav_drake.systems.planning.ros2 import messages as m

TRANSFORMS = "tf2_msgs/msg/TFMessage"


class Bag:
    """The messages of a bag.

    Times are in seconds since `zero`, in whole nanoseconds: those since 1970
    would lose digits. `last` is the place of the message that was read last.
    """

    def __init__(self, reader: Any) -> None:
        self._reader = reader
        self.zero = 0
        self._from_zero = False
        self.last = ""
        self.types = {it.topic: it.msgtype for it in reader.connections}
        self._defined = any(it.msgdef.data for it in reader.connections)

    def begin_at(self, topic: str) -> None:
        """Sets `zero` to the time of the first message of a topic, or of /tf.

        Raises:
            ValueError: If it is damaged.
        """
        topics = [topic] if topic else self.of_type(TRANSFORMS)
        begin = []
        for _, came, told in islice(self.messages(*topics), 2):
            header = getattr(told, "header", None)
            begin.append((m.nanoseconds(header.stamp) if header else 0, came))
        if begin:
            (stamp, came), (later, arrived) = begin[0], begin[-1]
            # (A node without a clock yet has 0, too; then its stamps leap.)
            near = 0 < later < max(0.5 * arrived, 1.0) * 1e9
            self._from_zero = not stamp and near
            no_stamp = not stamp and not self._from_zero
            self.zero = round(came * 1e9) if no_stamp else stamp

    def time(self, header: Any, came: float) -> float:
        """Returns the time of a message: its stamp, if it has one.

        0 is one only where stamps begin there, as those of simulations.
        """
        stamp = m.nanoseconds(header.stamp)
        told = stamp or self._from_zero
        return (stamp - self.zero) * 1e-9 if told else came

    def clock(self, time: float) -> str:
        """Returns a time as messages have it, in seconds."""
        seconds, rest = divmod(self.zero + round(time * 1e9), 10**9)
        return f"{seconds}.{rest:09d}".rstrip("0").rstrip(".")

    def place(self, topic: str, time: float) -> str:
        """Returns the place of a message in words."""
        return f"the message of topic {topic} at {self.clock(time)} s"

    def of_type(self, kind: str) -> list[str]:
        """Returns the topics of a type, in the order of the bag."""
        return [it for it, told in self.types.items() if told == kind]

    def messages(self, *topics: str) -> Iterator[tuple[str, float, Any]]:
        """Yields topics, the times when messages came, in s, and these.

        Raises:
            ValueError: If a message is damaged.
        """
        chosen = [it for it in self._reader.connections if it.topic in topics]
        if not chosen:
            return
        found = self._reader.messages(chosen)
        while True:
            with damage_told(f"cannot be read to its end, topics {topics}"):
                it, nanoseconds, data = next(found, (None, 0, b""))
            if it is None:
                return
            time = (nanoseconds - self.zero) * 1e-9
            self.last = self.place(it.topic, time)
            fault = f"{self.last} is damaged"
            if not self._defined:
                fault += (
                    f", or {it.msgtype} has other fields (the bag does not"
                    " define them; write it as MCAP with `ros2 bag convert`)"
                )
            with damage_told(fault):
                told = self._reader.deserialize(data, it.msgtype)
            yield it.topic, time, told

    def check(self, topic: str, time: float, numbers: dict[str, float]) -> None:
        """Refuses numbers of a message that are not finite, or too large."""
        for name, number in numbers.items():
            if not abs(number) <= LARGEST:
                raise ValueError(
                    f"{self.place(topic, time)} has {name} = {number:g}, which"
                    f" must be finite and at most {LARGEST:g} in size; cut the"
                    " bag there"
                )


@contextlib.contextmanager
def damage_told(what: str) -> Iterator[None]:
    """Turns what is raised while bytes of a bag are read into a ValueError.

    Damaged bytes make rosbags, and the libraries below it, raise anything.
    """
    try:
        yield
    except ImportError:
        raise
    except Exception as error:
        # (Of a file that cannot be read, it has the name.)
        if isinstance(error, OSError) and error.filename is not None:
            raise
        words = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(f"{what}: {words:.200}") from error
