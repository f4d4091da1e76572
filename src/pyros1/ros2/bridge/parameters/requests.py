"""Answers the queries of `pyros1 bridge param ros2:` for parameters of ROS 2 nodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from pyros1.bridge.parameters import ROS2_SITE, ParameterError, decode_parameter_request, encode_json_response
from pyros1.ground.errors import ServiceRefusal
from pyros1.ground.suggest import did_you_mean
from pyros1.ros2.bridge.parameters.nodes import ParameterNode
from pyros1.ros2.bridge.parameters.parameter_client import ParameterClient


def respond(
    body: bytes,
    nodes: Mapping[str, ParameterNode],
    parameter_client: ParameterClient,
    prepare: Callable[[ParameterNode], object],
) -> bytes:
    """Return the response to a request: the names of all nodes, all parameters of a node, or one of them. This waits
    for the node.

    Args:
        body: the request.
        nodes: the nodes whose parameters may be read.
        parameter_client: queries a node.
        prepare: waits until the node can be queried.

    Raises:
        ServiceRefusal: the request is invalid, there is no such node or parameter, or the node does not respond.
    """
    try:
        request = decode_parameter_request(body)
    except ParameterError as error:
        raise ServiceRefusal(str(error)) from None
    if request.site != ROS2_SITE:
        raise ServiceRefusal(f"there is no site {request.site}")
    if not request.name:
        return encode_json_response(sorted(nodes))
    name, parameter = _split(request.name, nodes)
    node = nodes[name]
    prepare(node)
    if not parameter:
        return encode_json_response(dict(sorted(parameter_client.values(node, parameter_client.names(node)).items())))
    values = parameter_client.values(node, [parameter]) if parameter in (names := parameter_client.names(node)) else {}
    if parameter not in values:
        what = "has no value" if parameter in names else f"is not there{did_you_mean(parameter, names)}"
        raise ServiceRefusal(
            f"parameter {parameter} of node {name} of ROS 2 {what}; for all parameters: "
            f"pyros1 bridge param {ROS2_SITE}: {name}"
        )
    return encode_json_response(values[parameter])


def _split(name: str, nodes: Mapping[str, ParameterNode]) -> tuple[str, str]:
    """Split a name into a node and a parameter; both can contain slashes.

    Raises:
        ServiceRefusal: there is no such node.
    """
    parts = name.split("/")
    for number in range(len(parts), 1, -1):
        node = "/".join(parts[:number])
        if node in nodes:
            return node, "/".join(parts[number:])
    known = f"; nodes with parameters: pyros1 bridge param {ROS2_SITE}:" if nodes else ""
    raise ServiceRefusal(
        f"{name} is neither a ROS 2 node whose parameters may be read, nor a parameter of one"
        f"{did_you_mean(name, nodes)}{known}"
    )
