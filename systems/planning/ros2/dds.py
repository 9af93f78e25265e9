"""ROS 2's topics over DDS, without ROS: by Cyclone DDS.

Topic ``/a/b`` is called ``rt/a/b`` there, and type ``pkg/msg/Name``
``pkg::msg::dds_::Name_``. Messages are encoded as in bags, so DDS gets bytes.
"""

from functools import cache
import os
from typing import Any
from weakref import WeakSet

from hunav_drake.systems.planning.ros2.message_types import (
    from_cdr,
    to_cdr,
    type_store,
)

# Only the loopback interface: nobody beyond this machine sees anything.
_LOOPBACK = """<CycloneDDS><Domain><General><Interfaces>
<NetworkInterface name="lo"/></Interfaces><AllowMulticast>false</AllowMulticast>
</General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<MaxAutoParticipantIndex>100</MaxAutoParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"""

_INTERFACE = """<CycloneDDS><Domain><General><Interfaces>
<NetworkInterface name="{}"/></Interfaces></General></Domain></CycloneDDS>"""


def default_domain() -> int:
    """Returns the number of the domain: ROS_DOMAIN_ID, or 0.

    Raises:
        ValueError: If it is not a whole number from 0 to 232.
    """
    text = os.environ.get("ROS_DOMAIN_ID") or "0"
    if not (text.isdecimal() and text.isascii() and int(text) <= 232):
        raise ValueError(
            "the environment variable ROS_DOMAIN_ID must be a whole number from"
            f" 0 to 232, got {text!r:.40}"
        )
    return int(text)


class Reader:
    """The messages of a topic that have arrived."""

    def __init__(self, reader: Any, type_name: str) -> None:
        """Constructs a Reader of a DataReader of Cyclone DDS."""
        self._reader = reader
        self._type_name = type_name

    def take(self) -> list[Any]:
        """Returns the messages that are not yet taken, the oldest first.

        Raises:
            ValueError: If one is damaged.
        """
        samples = self._reader.take(N=1000)
        return [
            from_cdr(it.cdr, self._type_name)
            for it in samples
            if getattr(it, "cdr", None) is not None
        ]

    @property
    def num_writers(self) -> int:
        """The number of writers of the topic."""
        return int(self._reader.get_subscription_matched_status().current_count)


class DdsNode:
    """Publishes and reads topics; ends with the object.

    All nodes of a process on one domain share its network interface: that of
    the first one. A value of CYCLONEDDS_URI, if any, takes its place.

    Attributes:
        domain: The number of the domain.
        network: The name of the network interface.
    """

    def __init__(self, domain: int | None = None, network: str = "lo") -> None:
        """Constructs a DdsNode.

        Args:
            domain: The number of the domain; by default `default_domain`.
            network: The name of the network interface.

        Raises:
            ImportError: If Cyclone DDS is not installed.
            ValueError: If there is no such network interface.
        """
        try:
            from cyclonedds.core import DDSException
            from cyclonedds.domain import DomainParticipant
        except ImportError as error:
            raise ImportError(
                "DDS needs cyclonedds: pip install 'hunav_drake[ros]'"
            ) from error
        self.network = network
        self.domain = default_domain() if domain is None else domain
        try:
            _configure(self.domain, network)
            self._participant = DomainParticipant(self.domain)
        except DDSException as error:
            own = os.environ.get("CYCLONEDDS_URI")
            raise ValueError(
                f"DDS cannot use network interface {network!r:.40} for domain"
                f" {self.domain} ({error}); `ip link` lists the interfaces"
                if not own
                else "DDS cannot use the configuration that the environment"
                f" variable CYCLONEDDS_URI names, {own!r:.80} ({error});"
                " correct or unset it"
            ) from error
        self._writers: dict[str, Any] = {}
        self._publications: Any = None
        _nodes.add(self)

    def advertise(
        self, topic: str, type_name: str, *, latched: bool = False
    ) -> None:
        """Lets others find a topic before it has messages.

        Readers that come later get the last message of a `latched` one.
        """
        from cyclonedds.pub import DataWriter

        if topic not in self._writers:
            writer = DataWriter(
                self._participant,
                self._topic(topic, type_name),
                _qos(latched=latched, depth=1 if latched else 100),
            )
            self._writers[topic] = writer

    def publish(self, topic: str, sent: Any, *, latched: bool = False) -> None:
        """Publishes a message on a topic, such as "/odom".

        It is not sent if nobody reads the topic and it is not `latched`.
        """
        self.advertise(topic, sent.__msgtype__, latched=latched)
        if not (latched or self.num_readers(topic)):
            return
        writer = self._writers[topic]
        sample = writer.data_type.__new__(writer.data_type)
        sample.cdr = to_cdr(sent)
        writer.write(sample)

    def num_readers(self, topic: str) -> int:
        """Returns the number of readers of a topic that is published."""
        status = self._writers[topic].get_publication_matched_status()
        return int(status.current_count)

    def is_read(self, topic: str) -> bool:
        """Returns whether somebody reads a topic, or may begin to."""
        return topic not in self._writers or self.num_readers(topic) > 0

    def num_arrivals(self, *topics: str) -> int:
        """Returns how many readers have come to topics; by default, to all.

        It never falls: those who have gone count, too.
        """
        return sum(
            self._writers[it].get_publication_matched_status().total_count
            for it in topics or self._writers
        )

    def published_types(self, topic: str, *, beyond: bool = False) -> list[str]:
        """Returns the types as which a topic is published, each once.

        By anybody, or only `beyond` this process.
        """
        from cyclonedds.builtin import (
            BuiltinDataReader,
            BuiltinTopicDcpsPublication,
        )
        from cyclonedds.core import (
            InstanceState,
            ReadCondition,
            SampleState,
            ViewState,
        )

        if self._publications is None:
            reader = BuiltinDataReader(
                self._participant, BuiltinTopicDcpsPublication
            )
            # (Without those who are gone.)
            present = ViewState.Any | SampleState.Any | InstanceState.Alive
            self._publications = reader, ReadCondition(reader, present)
        reader, condition = self._publications
        own = {it._participant.guid for it in _nodes} if beyond else set()
        names = {
            it.type_name.replace("::dds_::", "::").replace("::", "/")
            for it in reader.read(10000, condition)
            if it.topic_name == f"rt{topic}" and it.participant_key not in own
        }
        return sorted(name.removesuffix("_") for name in names)

    def subscribe(
        self,
        topic: str,
        type_name: str,
        *,
        latched: bool = False,
        reliable: bool = True,
    ) -> Reader:
        """Returns a reader of a topic of other nodes.

        One that is not `reliable` also reads topics whose writers are not.
        """
        from cyclonedds.sub import DataReader

        reader = DataReader(
            self._participant,
            self._topic(topic, type_name),
            _qos(latched=latched, depth=1000, reliable=reliable),
        )
        return Reader(reader, type_name)

    def _topic(self, topic: str, type_name: str) -> Any:
        from cyclonedds.topic import Topic

        return Topic(
            self._participant, f"rt{topic}", _dds_type(type_name), _qos()
        )


# The nodes of this process.
_nodes: WeakSet[DdsNode] = WeakSet()


@cache
def _configure(domain: int, network: str) -> Any:
    """Configures a domain of this process, once."""
    from cyclonedds.domain import Domain

    if os.environ.get("CYCLONEDDS_URI"):
        return None
    text = _LOOPBACK if network == "lo" else _INTERFACE.format(network)
    return Domain(domain, text)


def _qos(
    *, latched: bool = False, depth: int = 100, reliable: bool = True
) -> Any:
    """Returns the quality of service of a topic.

    Writers are reliable, which also serves readers that are not.
    """
    from cyclonedds.qos import Policy, Qos
    from cyclonedds.util import duration

    return Qos(
        Policy.Reliability.Reliable(duration(seconds=1))
        if reliable
        else Policy.Reliability.BestEffort,
        Policy.Durability.TransientLocal
        if latched
        else Policy.Durability.Volatile,
        Policy.History.KeepLast(depth),
        # (Nobody reads what it has written itself.)
        Policy.IgnoreLocal.Participant,
        Policy.DataRepresentation(
            use_cdrv0_representation=True, use_xcdrv2_representation=False
        ),
    )


@cache
def _dds_type(type_name: str) -> Any:
    """Returns the class of a message for Cyclone DDS, which holds bytes."""
    from cyclonedds.idl import make_idl_struct
    from cyclonedds.idl.annotations import final

    package, _, name = type_name.split("/")
    _, fields = type_store().fielddefs[type_name]
    made = make_idl_struct(
        f"{name}_",
        f"{package}.msg.dds_.{name}_",
        {field: _dds_field(kind) for field, kind in fields},
    )
    final(made)

    def serialize(self: Any, *_: Any, **__: Any) -> bytes:
        cdr: bytes = self.cdr
        return cdr

    def deserialize(cls: Any, data: bytes, *_: Any, **__: Any) -> Any:
        sample = cls.__new__(cls)
        sample.cdr = bytes(data)
        return sample

    made.serialize = serialize
    made.deserialize = classmethod(deserialize)
    return made


def _dds_field(kind: Any) -> Any:
    from cyclonedds.idl import types
    from rosbags.interfaces import Nodetype

    node, detail = kind
    if node == Nodetype.NAME:
        return _dds_type(detail)
    if node == Nodetype.BASE:
        known = {"string": str, "bool": bool, "byte": types.uint8}
        known["char"] = types.uint8
        return known.get(detail[0]) or getattr(types, detail[0])
    inner, count = detail
    element = _dds_field(inner)
    if node == Nodetype.SEQUENCE:
        return types.sequence[element]
    return types.array[element, count]
