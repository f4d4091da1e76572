"""What a bridge sends to ROS 2 of the messages that it gets in ROS 1."""

from __future__ import annotations

from typing import Any
from unittest.mock import Mock

import pytest

from pyros1.bridge.bridge_publishers import BRIDGE_FIELD
from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.rules.rules import Priority
from pyros1.msgs import AnyMsg, load_message
from pyros1.ros2.bridge.counts import Counts
from pyros1.ros2.bridge.outgoing import OutgoingMessages
from pyros1.ros2.bridge.plan import AnnouncedTopic
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.qos import Qos

STRING = load_message("std_msgs/String")
KEY = DataKey(0, "/a", "std_msgs/msg/String", "RIHS01_x")
ROUTE = "0/a/std_msgs::msg::dds_::String_/RIHS01_x"
BODY, CDR = b"\2\0\0\0hi", b"\0\1\0\0\3\0\0\0hi\0"


def outgoing(latched: bool = False) -> tuple[OutgoingMessages, Counts, list[Send], list[str]]:
    """Return what sends /a, how much it has sent, its packets, and its warnings."""
    packets, warnings, counts = [], [], Counts()
    pair = TypePairs().for_ros1("std_msgs/String", STRING._md5sum, STRING._full_text)
    local = LocalTopic("/a", pair.ros1, pair.md5sum, pair.definition, latched, ("/talker",))
    found = OutgoingMessages(
        Mock(), Mock(bridges={"/bridge"}), Mock(put=packets.append), counts, lambda text, error: warnings.append(text)
    )
    found.topics = {"/a": [(KEY, AnnouncedTopic(local, pair, Qos(transient_local=latched), True, Priority.LOW))]}
    found.set_publishers([f"{ROUTE} /talker" if latched else ROUTE])
    return found, counts, packets, warnings


def message(body: bytes = BODY, **header: str) -> Any:
    received = AnyMsg(body)
    received._connection_header = {"callerid": "/talker", "md5sum": STRING._md5sum, **header}
    return received


def test_a_message_is_converted_and_counted() -> None:
    sends, counts, packets, _ = outgoing()
    sends.on_message("/a", message())
    sends.on_message("/other", message())
    assert packets == [Send(ROUTE, b"", CDR, Priority.LOW)]
    assert (counts.to_ros2("/a").messages, counts.to_ros2("/a").bytes) == (1, len(CDR))


@pytest.mark.parametrize(
    ("unusable", "drops"),
    [
        (message(md5sum="0" * 32), {"with a different md5sum": 1}),
        (message(b"\xff\0\0\0"), {"could not be converted": 1}),
        (message(**{BRIDGE_FIELD: "red"}), {}),
        (message(callerid="/bridge"), {}),
    ],
)
def test_what_is_not_sent(unusable: Any, drops: dict[str, int]) -> None:
    sends, counts, packets, warnings = outgoing()
    sends.on_message("/a", unusable)
    assert not packets and counts.to_ros2("/a").drops == drops and counts.to_ros2("/a").messages == 0
    assert bool(warnings) == ("could not be converted" in drops)


def test_latched_messages_wait_for_their_publisher_in_ros2() -> None:
    sends, _, packets, _ = outgoing(latched=True)
    sends.on_message("/a", message())
    sends.on_message("/a", message(callerid="/new"))
    assert [packet.key for packet in packets] == [f"{ROUTE} /talker"]
    sends.send_early()
    assert len(packets) == 1
    sends.set_publishers([f"{ROUTE} /new"])
    sends.send_early()
    assert packets[1:] == [Send(f"{ROUTE} /new", b"", CDR, Priority.LOW)]
