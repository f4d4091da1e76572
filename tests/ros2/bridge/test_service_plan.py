"""Which services a bridge to ROS 2 offers and provides, given those of both sides."""

from __future__ import annotations

from typing import Any

from pyros1.bridge.exchange.services.served import LocalService
from pyros1.ground.errors import UnknownTypeError
from pyros1.ros2.bridge.rules import Ros2Rules
from pyros1.ros2.bridge.service_plan import ServicePlan, plan_services
from pyros1.ros2.pairs.type_pairs import ServicePair
from pyros1.ros2.zenoh.graph import Service
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.tokens import Entity, Kind

TYPE = "std_srvs/srv/SetBool"


class FakeTypes:
    """Types whose md5 sums and hashes say what they are."""

    def service_for_ros1(self, type: str, md5sum: str, hash: str | None = None) -> ServicePair:
        package, _, name = type.partition("/")
        if package == "unknown" or hash not in {None, "old", "new"}:
            raise UnknownTypeError(f"no definition of {type}")
        transcoder: Any = None
        return ServicePair(type, md5sum, f"{package}/srv/{name}", hash or "new", transcoder, transcoder)

    def service_for_ros2(self, type: str, hash: str) -> ServicePair:
        return self.service_for_ros1(type.replace("/srv/", "/"), "md5", hash)


def local(name: str, type: str = "std_srvs/SetBool") -> LocalService:
    return LocalService(name, type, "md5", f"{type}Request", f"{type}Response", "/server")


def entity(name: str, type: str = TYPE, hash: str = "new", node: str = "n") -> Entity:
    return Entity(0, "ab", 0, 1, Kind.SERVICE, node, topic=name, type=type, hash=hash)


def plan(
    services: list[LocalService],
    servers: list[Entity] | None = None,
    clients: list[Entity] | None = None,
    rules: Ros2Rules | None = None,
    taken: dict[str, str] | None = None,
    offered: tuple[str, ...] = (),
) -> ServicePlan:
    names = {each.topic for each in [*(servers or []), *(clients or [])]}
    there = {
        name: Service(
            tuple(each for each in servers or [] if each.topic == name),
            tuple(each for each in clients or [] if each.topic == name),
        )
        for name in names
    }
    taken = {each.name: each.node for each in services} if taken is None else taken
    return plan_services(7, rules or Ros2Rules(), services, taken, there, offered, FakeTypes())


def key(name: str, hash: str = "new", type: str = TYPE) -> DataKey:
    return DataKey(7, name, type, hash)


def test_ros2_sees_services_of_ros1() -> None:
    made = plan([local("/a"), local("/b", "std_srvs/Empty")])
    assert made.offers.keys() == {key("/a"), key("/b", type="std_srvs/srv/Empty")}
    assert made.offers[key("/a")].local.name == "/a" and not made.provides and not made.problems


def test_clients_with_another_definition() -> None:
    assert plan([local("/a")], [], [entity("/a", hash="old")]).offers.keys() == {key("/a", "old")}
    made = plan([local("/a")], [], [entity("/a", hash="old"), entity("/a")])
    assert made.offers.keys() == {key("/a", "old"), key("/a")} and not made.problems
    made = plan([local("/a")], [], [entity("/a", hash="strange")])
    assert made.offers.keys() == {key("/a")} and made.problems == {"/a": "no definition of std_srvs/SetBool"}
    made = plan([local("/a")], [], [entity("/a", "std_srvs/srv/Empty", node="caller")])
    assert made.offers.keys() == {key("/a")}
    assert made.problems == {"/a": "/caller calls it as std_srvs/srv/Empty, not std_srvs/srv/SetBool"}


def test_services_that_ros2_cannot_have() -> None:
    made = plan([local("/a", "unknown/Type"), local("/1st")])
    assert made.problems == {"/a": "no definition of unknown/Type", "/1st": "ROS 2 does not allow such a name"}
    assert not made.offers


def test_ros1_sees_services_of_ros2() -> None:
    made = plan([], [entity("/b", node="server"), entity("/b", node="another")], [entity("/nobody_offers_this")])
    assert made.provides.keys() == {"/b"} and not made.problems
    provided = made.provides["/b"]
    assert (provided.key, provided.pair.ros1, provided.node) == (key("/b"), "std_srvs/SetBool", "/server")


def test_two_definitions_in_ros2() -> None:
    made = plan([], [entity("/b", hash="old", node="first"), entity("/b")])
    assert made.provides["/b"].key == key("/b", "old")
    assert made.problems["/b"].endswith("calls go to /first")
    made = plan([], [entity("/b", "unknown/srv/Type"), entity("/b")])
    assert made.provides["/b"].key == key("/b") and made.problems == {"/b": "no definition of unknown/Type"}


def test_both_sides_provide_it() -> None:
    made = plan([local("/a")], [entity("/a", node="there")])
    assert not made.offers and not made.provides
    assert made.problems == {"/a": "/server provides it in ROS 1, and /there in ROS 2"}
    made = plan([], [entity("/a", node="there")], taken={"/a": "/another_bridge"})
    assert not made.provides and made.problems == {"/a": "/another_bridge provides it in ROS 1, and /there in ROS 2"}


def test_two_bridges_do_not_give_way_to_each_other_again_and_again() -> None:
    made = plan([local("/a")], [entity("/a", node="there")], offered=("/a",))
    assert made.offers.keys() == {key("/a")} and not made.provides
    assert made.problems == {"/a": "/server provides it in ROS 1, and /there in ROS 2"}


def test_rules() -> None:
    made = plan([local("/a"), local("/b")], [entity("/c"), entity("/d")], rules=Ros2Rules(["/a"], ["/c"]))
    assert made.offers.keys() == {key("/a")} and made.provides.keys() == {"/c"}
    made = plan([local("/node/get_loggers")], [entity("/node/get_parameters"), entity("/fly/_action/send_goal")])
    assert made == ServicePlan()
