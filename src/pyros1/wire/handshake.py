"""The rules of TCPROS connection headers, which decide whether two programs can connect, for topics and services.

The connecting side sends a header. The accepting side responds with its own header, or with the single field ``error``
before it closes the connection. Rules (https://wiki.ros.org/ROS/TCPROS):

* a first header with the field ``topic`` is for a publisher; otherwise, one with the field ``service`` is for a
  service;
* ``md5sum`` must be equal; ``*`` on either side matches any; ``type`` may differ if ``md5sum`` is equal;
* the response contains the actual type, md5sum and full definition, whatever type was requested.

Refusals name the types of both sides, so that the user can find out which one is wrong.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from pyros1.ground.errors import ConnectionRefusedByPeerError, ProtocolError
from pyros1.ground.terminal_text import one_line

WILDCARD = "*"


class Refusal(Exception):
    """The connection is refused; the peer receives the message in the header field ``error``."""


class TopicType(NamedTuple):
    """A topic's type: its name, md5 sum and full definition; the name and md5 sum are ``*`` for any type."""

    name: str
    md5sum: str
    definition: str = ""


class ServiceType(NamedTuple):
    """A service's type: its name and md5 sum, and the type names of the request and the response."""

    name: str
    md5sum: str
    request: str
    response: str


def make_subscriber_header(
    caller_id: str, topic: str, requested_type: TopicType, tcp_nodelay: bool, extra: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Return the header that a subscriber sends to a publisher (T06)."""
    return {
        **(extra or {}),
        "callerid": caller_id,
        "topic": topic,
        "type": requested_type.name,
        "md5sum": requested_type.md5sum,
        "message_definition": requested_type.definition,
        "tcp_nodelay": "1" if tcp_nodelay else "0",
    }


def _require(header: Mapping[str, str], *names: str) -> None:
    for name in names:
        if not header.get(name):
            raise Refusal(f"Missing required '{name}' field")


def _md5_matches(md5sum: str, other_md5sum: str) -> bool:
    return md5sum == other_md5sum or WILDCARD in (md5sum, other_md5sum)


def make_publisher_response(
    header: Mapping[str, str],
    node_name: str,
    topic: str,
    offered_type: TopicType,
    latching: bool,
    extra: Mapping[str, str] | None = None,
) -> dict[str, str]:
    """Return a publisher's response to a subscriber's header (T06, T07, T09-T12).

    Raises:
        Refusal: a field is missing or the md5 sums differ.
    """
    _require(header, "topic", "md5sum", "callerid")
    wanted_type, wanted_md5 = header.get("type", offered_type.name), header["md5sum"]
    if not _md5_matches(wanted_md5, offered_type.md5sum):
        if wanted_type != offered_type.name:
            raise Refusal(f"topic types do not match: [{wanted_type}] vs. [{offered_type.name}]")
        raise Refusal(
            f"Client [{header['callerid']}] wants topic [{topic}] to have datatype/md5sum "
            f"[{wanted_type}/{wanted_md5}], but our version has [{offered_type.name}/{offered_type.md5sum}] "
            "Dropping connection."
        )
    return {
        **(extra or {}),
        "callerid": node_name,
        "topic": topic,
        "type": offered_type.name,
        "md5sum": offered_type.md5sum,
        "message_definition": offered_type.definition,
        "latching": "1" if latching else "0",
    }


def _check_response(header: Mapping[str, str], sent: Mapping[str, str] | None, peer: str, *required: str) -> None:
    if header == sent:
        raise ProtocolError(f"{peer} only sends back what it receives: another program is using its port now")
    if "error" in header:
        raise ConnectionRefusedByPeerError(f"{peer} refused the connection: {one_line(header['error'])}")
    for name in required:
        if name not in header:  # an empty field is accepted, as in stock ROS
            raise ProtocolError(f"{peer} responded without the field {name!r}")


def check_publisher_response(
    header: Mapping[str, str],
    topic: str,
    requested_type: TopicType,
    publisher: str,
    sent: Mapping[str, str] | None = None,
) -> str:
    """Check a publisher's response to a subscriber's header.

    Comparing the md5 sums is up to the publisher: as in stock ROS, a subscriber accepts messages from a publisher that
    does not compare them (T15).

    Args:
        publisher: what to call the publisher in error messages, usually its API URI.
        sent: the subscriber's header, to recognise a program that echoes it; None if no header was sent.

    Returns:
        A warning if the md5 sums differ, or an empty string.

    Raises:
        ConnectionRefusedByPeerError: the publisher refused.
        ProtocolError: a field is missing.
    """
    _check_response(header, sent, f"publisher {publisher} of {topic}", "type", "md5sum")
    if _md5_matches(requested_type.md5sum, header["md5sum"]):
        return ""
    return (
        f"publisher {publisher} sends {topic} as {one_line(header['type'])} [{one_line(header['md5sum'])}], "
        f"but this subscriber wants {requested_type.name} [{requested_type.md5sum}]: its messages may be wrong"
    )


def make_service_client_header(
    caller_id: str, service: str, requested_type: ServiceType, persistent: bool, extra: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Return the header that a client sends to a service (T23)."""
    return {
        **(extra or {}),
        "callerid": caller_id,
        "service": service,
        "type": requested_type.name,
        "md5sum": requested_type.md5sum,
        "persistent": "1" if persistent else "0",
    }


def make_service_response(
    header: Mapping[str, str], node_name: str, service: str, offered_type: ServiceType
) -> dict[str, str]:
    """Return a service's response to a client's header (T24, T25, T33).

    Raises:
        Refusal: a field is missing or the md5 sums differ.
    """
    _require(header, "service", "md5sum", "callerid")
    if not _md5_matches(header["md5sum"], offered_type.md5sum):
        raise Refusal(
            f"request from [{header['callerid']}]: md5sums do not match: "
            f"[{header['md5sum']}] vs. [{offered_type.md5sum}] (service {service} is of type {offered_type.name})"
        )
    return {
        "callerid": node_name,
        "service": service,
        "type": offered_type.name,
        "md5sum": offered_type.md5sum,
        "request_type": offered_type.request,
        "response_type": offered_type.response,
    }


def check_service_response(
    header: Mapping[str, str], service: str, requested_type: ServiceType, sent: Mapping[str, str] | None = None
) -> str:
    """Check a service's response to a client's header.

    roscpp servers send no ``type`` (T24). Comparing the md5 sums is up to the server: as in rospy, a client accepts
    responses from a server that does not compare them.

    Args:
        sent: the client's header, as in `check_publisher_response`.

    Returns:
        A warning if the md5 sums differ, or an empty string.

    Raises:
        ConnectionRefusedByPeerError: the service refused.
        ProtocolError: the md5 sum is missing.
    """
    _check_response(header, sent, f"service {service}", "md5sum")
    if _md5_matches(requested_type.md5sum, header["md5sum"]):
        return ""
    return (
        f"service {service} has md5sum [{one_line(header['md5sum'])}], but this client's {requested_type.name} has "
        f"[{requested_type.md5sum}]: its responses may be wrong"
    )


def is_true(text: str | None) -> bool:
    """Return whether the text of a header flag is ``1`` or ``true``, in upper or lower case."""
    return text is not None and text.strip().lower() in ("1", "true")
