"""Which fields only one side has: said once."""

from __future__ import annotations

from pyros1.bridge.exchange.services.served import LocalService
from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.rules.rules import Priority
from pyros1.msgs import load_message, load_service
from pyros1.ros2.bridge.plan import AnnouncedTopic, Plan, TakenTopic
from pyros1.ros2.bridge.service_plan import OfferedService, ProvidedService, ServicePlan
from pyros1.ros2.pairs.differences import Differences
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.qos import Qos
from pyros1.ros2_types.definitions import parse_types
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.type_hash import type_hash

LINE = (
    "only ROS 2 has variance: left out on the way there, zero or empty on the way back",
    "sensor_msgs/Range is sensor_msgs/msg/Range, but ",
)


def test_each_difference_is_said_once() -> None:
    pairs, differences = TypePairs(), Differences()
    name = "sensor_msgs/msg/Range"
    pair = pairs.for_ros2(name, type_hash(name, distribution_types()))
    key = DataKey(0, "/range", name, pair.hash)
    takes = Plan(takes={"/range": TakenTopic(pair, {key: (pair, Qos())})})
    assert [*differences.new(takes, ServicePlan())] == [LINE[1] + LINE[0]]
    local = LocalTopic("/range", pair.ros1, pair.md5sum, pair.definition, False, ("/n",))
    announces = Plan(announces={key: AnnouncedTopic(local, pair, Qos(), True, Priority.NORMAL)})
    assert [*differences.new(announces, ServicePlan())] == []
    assert [*Differences().new(announces, ServicePlan())] == [LINE[1] + LINE[0]]


def test_types_without_differences_and_services() -> None:
    text = "int8 speed\nbool data\n---\nstring message\n"
    pairs = TypePairs("jazzy", installed=parse_types("std_srvs/srv/SetBool", text))
    service = load_service("std_srvs/SetBool")
    pair = pairs.service_for_ros1("std_srvs/SetBool", service._md5sum)
    key = DataKey(0, "/s", pair.ros2, pair.hash)
    string = load_message("std_msgs/String")
    plain = pairs.for_ros1("std_msgs/String", string._md5sum, string._full_text)
    plan = Plan(takes={"/a": TakenTopic(plain, {key: (plain, Qos())})})
    local = LocalService("/s", pair.ros1, pair.md5sum, "SetBoolRequest", "SetBoolResponse", "/n")
    for services in (
        ServicePlan(offers={key: OfferedService(local, pair)}),
        ServicePlan(provides={"/s": ProvidedService(key, pair, "n")}),
    ):
        lines = [*Differences().new(plan, services)]
        assert [line.split(",")[0] for line in lines] == [
            "std_srvs/SetBoolRequest is std_srvs/srv/SetBool_Request",
            "std_srvs/SetBoolResponse is std_srvs/srv/SetBool_Response",
        ]
        assert "only ROS 2 has speed" in lines[0] and "only ROS 1 has success" in lines[1]
