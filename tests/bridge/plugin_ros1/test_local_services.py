"""Which services a bridge finds on its master."""

from __future__ import annotations

from collections.abc import Callable

from pyros1.bridge.local_graph import STATUS_SERVICE
from pyros1.bridge.plugin_ros1.local_services import LocalServices
from pyros1.bridge.plugin_ros1.plan import LocalService
from pyros1.graph import Graph
from pyros1.msgs.std_srvs.srv import SetBool
from pyros1.node import Node


def test_services_with_types(make_node: Callable[..., Node]) -> None:
    node, bridge = make_node("user"), make_node("bridge")
    node.advertise_service("/set", SetBool, lambda _: (True, ""))
    node.advertise_service("/other", SetBool, lambda _: (True, ""))
    bridge.advertise_service(f"~{STATUS_SERVICE}", "std_srvs/Trigger", lambda _: (True, ""))
    bridge.advertise_service("/far", SetBool, lambda _: (True, ""))
    local = LocalServices(Graph(bridge.master), lambda name: name == "/set")
    found = {service.name: service for service in local.services()}
    assert found["/set"] == LocalService("/set", "std_srvs/SetBool", SetBool._md5sum)
    assert found["/other"] == LocalService("/other"), "its type does not matter"
    assert "/far" not in found and f"/bridge/{STATUS_SERVICE}" not in found and local.problems == {}


def test_a_provider_that_does_not_answer(make_node: Callable[..., Node], closed_port: int) -> None:
    node = make_node("user")
    node.master.register_service("/dead", f"rosrpc://127.0.0.1:{closed_port}", node.uri)
    local = LocalServices(Graph(node.master), lambda name: name == "/dead")
    assert LocalService("/dead") in local.services()
    assert local.problems == {"/dead": "its provider has not reported its type"}
