"""Requests of other sites to read parameters of this site's master, and the responses.

A request is JSON; a response is a value encoded in XML-RPC, as masters send it, which keeps its exact type. Responses
from ROS 2 are JSON, since its parameters can be integers and strings that XML-RPC cannot encode.
"""

from __future__ import annotations

import json
from typing import Any, NamedTuple

from pyros1.bridge.names import MAX_NAME_LENGTH
from pyros1.bridge.rules.rules import Rules
from pyros1.bridge.rules.services import may_read
from pyros1.ground.errors import Error, ParameterNotSetError, ProtocolError, ServiceRefusal
from pyros1.ground.names import is_legal_name
from pyros1.net.master_client import MasterClient
from pyros1.wire.xmlrpc import dumps_response, loads_response

PARAMETER_SERVICE = "bridge_parameters"
"""Name, below a bridge's name, of the service by which local programs read other sites' parameters."""
ROS2_SITE = "ros2"
"""The name for ROS 2 in place of a site's name, for a bridge to ROS 2."""
_MAX_REQUEST = 2_000


class ParameterError(Error, ValueError):
    """A request or response is invalid."""


class ParameterRequest(NamedTuple):
    """A request to read parameters of a site.

    Attributes:
        site: the site.
        name: a parameter's or namespace's full name; empty for the names of all parameters that may be read.
    """

    site: str
    name: str = ""


def encode_parameter_request(request: ParameterRequest) -> bytes:
    """Return a request as bytes."""
    return json.dumps([*request]).encode()


def decode_parameter_request(body: bytes) -> ParameterRequest:
    """Decode a request. Its name may be one that only ROS 2 allows; `check_name` checks for ROS 1.

    Raises:
        ParameterError: it is not valid.
    """
    try:
        value = json.loads(body) if len(body) <= _MAX_REQUEST else None
    except (ValueError, RecursionError):
        value = None
    if not (isinstance(value, list) and len(value) == 2 and all(isinstance(each, str) for each in value)):
        raise ParameterError("not a request for parameters")
    site, name = value
    if name and not (name[0] == "/" and len(name) <= MAX_NAME_LENGTH and name.isprintable()):
        raise _name_error(name)
    return ParameterRequest(site, name if name == "/" else name.rstrip("/"))


def check_name(request: ParameterRequest) -> None:
    """Check that ROS 1 allows the name in a request.

    Raises:
        ParameterError: it does not.
    """
    if request.name not in ("", "/") and not is_legal_name(request.name):
        raise _name_error(request.name)


def _name_error(name: str) -> ParameterError:
    return ParameterError(f"{name!r:.80} is not the full name of a parameter")


def encode_json_response(value: Any) -> bytes:
    """Return a response as JSON instead of XML-RPC."""
    return json.dumps([value]).encode()


def decode_parameter_response(body: bytes) -> Any:
    """Return the value in a response.

    Raises:
        ProtocolError: it is not valid.
    """
    if body[:1] != b"[":
        return loads_response(body)
    try:
        (value,) = json.loads(body)
    except (ValueError, RecursionError):
        raise ProtocolError("the bridge's response is not valid") from None
    return value


def respond(rules: Rules, master: MasterClient, body: bytes) -> bytes:
    """Return the response to another site's request. This waits for the master.

    Args:
        rules: this site's rules.
        master: this site's master.
        body: the request.

    Raises:
        ServiceRefusal: the request is invalid, reading is not allowed, or there is no such parameter. Error: the master
        does not respond.
    """
    try:
        request = decode_parameter_request(body)
        check_name(request)
    except ParameterError as error:
        raise ServiceRefusal(str(error)) from None
    if not request.name:
        return dumps_response([name for name in sorted(master.get_param_names()) if may_read(rules, name)])
    refusal = f"site {rules.site} has no parameter {request.name} that others may read"
    try:
        value = master.get_param(request.name)
    except ParameterNotSetError:
        raise ServiceRefusal(refusal) from None
    readable = _readable(rules, request.name.rstrip("/"), value)
    if readable is None:
        raise ServiceRefusal(refusal)
    return dumps_response(readable)


def _readable(rules: Rules, name: str, value: Any) -> Any:
    """Return the part of a value that other sites may read; None if there is none."""
    if not isinstance(value, dict) or not value:
        return value if may_read(rules, name) else None
    parts = {key: _readable(rules, f"{name}/{key}", item) for key, item in value.items()}
    return {key: part for key, part in parts.items() if part is not None} or None
