"""Which programs may connect to each other: the rules of the TCPROS connection headers, for topics and services.

A connecting side sends a header; the accepting side answers with its own, or with the single field ``error`` and
closes. Rules (https://wiki.ros.org/ROS/TCPROS):

* the first header decides: with ``topic`` it is for a publisher, else with ``service`` for a service;
* ``md5sum`` must be equal, ``*`` on either side matches any; ``type`` may differ if ``md5sum`` is equal;
* the answer carries the real type, md5sum and full definition, whatever was asked for.

Refusals name both sides' types, because the person who reads them has to find the one that is wrong.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from pyros1.ground.errors import ConnectionRefusedByPeerError, ProtocolError
from pyros1.ground.terminal_text import one_line

ANY = "*"


class Refusal(Exception):
    """The request cannot be granted; the text goes to the peer as ``error=``."""


class TopicType(NamedTuple):
    """Type of a topic: type name, md5 sum and full definition text; ``*`` for any."""

    name: str
    md5sum: str
    definition: str = ""


class ServiceType(NamedTuple):
    """Type of a service: type names of service, request and response, and the service's md5 sum."""

    name: str
    md5sum: str
    request: str
    response: str


def subscriber_header(
    caller_id: str, topic: str, wanted: TopicType, tcp_nodelay: bool, extra: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Return the header that a subscriber sends to a publisher (T06)."""
    return {
        **(extra or {}),
        "callerid": caller_id,
        "topic": topic,
        "type": wanted.name,
        "md5sum": wanted.md5sum,
        "message_definition": wanted.definition,
        "tcp_nodelay": "1" if tcp_nodelay else "0",
    }


def _require(header: Mapping[str, str], *names: str) -> None:
    for name in names:
        if not header.get(name):
            raise Refusal(f"Missing required '{name}' field")


def _md5_equal(a: str, b: str) -> bool:
    return a == b or ANY in (a, b)


def answer_subscriber(
    header: Mapping[str, str],
    node: str,
    topic: str,
    offered: TopicType,
    latching: bool,
    extra: Mapping[str, str] | None = None,
) -> dict[str, str]:
    """Return a publisher's answer to a subscriber's header (T06, T07, T09-T12).

    Raises:
        Refusal: a field is missing or the md5 sums differ.
    """
    _require(header, "topic", "md5sum", "callerid")
    wanted_type, wanted_md5 = header.get("type", offered.name), header["md5sum"]
    if not _md5_equal(wanted_md5, offered.md5sum):
        if wanted_type != offered.name:
            raise Refusal(f"topic types do not match: [{wanted_type}] vs. [{offered.name}]")
        raise Refusal(
            f"Client [{header['callerid']}] wants topic [{topic}] to have datatype/md5sum "
            f"[{wanted_type}/{wanted_md5}], but our version has [{offered.name}/{offered.md5sum}] Dropping connection."
        )
    return {
        **(extra or {}),
        "callerid": node,
        "topic": topic,
        "type": offered.name,
        "md5sum": offered.md5sum,
        "message_definition": offered.definition,
        "latching": "1" if latching else "0",
    }


def _check_answer(header: Mapping[str, str], sent: Mapping[str, str] | None, who: str, *needed: str) -> None:
    if header == sent:
        raise ProtocolError(f"{who} only sends back what it receives: another program is using its port now")
    if "error" in header:
        raise ConnectionRefusedByPeerError(f"{who} refused the connection: {one_line(header['error'])}")
    for name in needed:
        if name not in header:  # it may be empty, as for stock
            raise ProtocolError(f"{who} answered without the field {name!r}")


def check_publisher_answer(
    header: Mapping[str, str],
    topic: str,
    wanted: TopicType,
    publisher: str,
    sent: Mapping[str, str] | None = None,
) -> str:
    """Check a publisher's answer to a subscriber's header.

    To compare the md5 sums is the publisher's task: as in stock, a subscriber takes what one sends that does not (T15).

    Args:
        publisher: its name in error messages, usually its API URI.
        sent: the subscriber's header: a program that echoes would seem to be a publisher. None: there was none.

    Returns:
        A warning if the md5 sums differ, else nothing.

    Raises:
        ConnectionRefusedByPeerError: the publisher refused.
        ProtocolError: a field is missing.
    """
    _check_answer(header, sent, f"publisher {publisher} of {topic}", "type", "md5sum")
    if _md5_equal(wanted.md5sum, header["md5sum"]):
        return ""
    return (
        f"publisher {publisher} sends {topic} as {one_line(header['type'])} [{one_line(header['md5sum'])}], "
        f"but this subscriber wants {wanted.name} [{wanted.md5sum}]: its messages may be wrong"
    )


def service_client_header(
    caller_id: str, service: str, wanted: ServiceType, persistent: bool, extra: Mapping[str, str] | None = None
) -> dict[str, str]:
    """Return the header that a client sends to a service (T23)."""
    return {
        **(extra or {}),
        "callerid": caller_id,
        "service": service,
        "type": wanted.name,
        "md5sum": wanted.md5sum,
        "persistent": "1" if persistent else "0",
    }


def answer_service_client(header: Mapping[str, str], node: str, service: str, offered: ServiceType) -> dict[str, str]:
    """Return a service's answer to a client's header (T24, T25, T33).

    Raises:
        Refusal: a field is missing or the md5 sums differ.
    """
    _require(header, "service", "md5sum", "callerid")
    if not _md5_equal(header["md5sum"], offered.md5sum):
        raise Refusal(
            f"request from [{header['callerid']}]: md5sums do not match: [{header['md5sum']}] vs. [{offered.md5sum}]"
            f" (service {service} is of type {offered.name})"
        )
    return {
        "callerid": node,
        "service": service,
        "type": offered.name,
        "md5sum": offered.md5sum,
        "request_type": offered.request,
        "response_type": offered.response,
    }


def check_service_answer(
    header: Mapping[str, str], service: str, wanted: ServiceType, sent: Mapping[str, str] | None = None
) -> str:
    """Check a service's answer to a client's header.

    roscpp servers send no ``type`` (T24). To compare the md5 sums is the server's task: as in rospy, a
    client takes the responses of one that does not.

    Args:
        sent: the client's header, as in `check_publisher_answer`.

    Returns:
        A warning if the md5 sums differ, else nothing.

    Raises:
        ConnectionRefusedByPeerError: the service refused.
        ProtocolError: the md5 sum is missing.
    """
    _check_answer(header, sent, f"service {service}", "md5sum")
    if _md5_equal(wanted.md5sum, header["md5sum"]):
        return ""
    return (
        f"service {service} has md5sum [{one_line(header['md5sum'])}], but this client's {wanted.name} has "
        f"[{wanted.md5sum}]: its responses may be wrong"
    )


def is_true(text: str | None) -> bool:
    """Return the value of a header flag: ``1`` and ``true`` are true."""
    return text is not None and text.strip().lower() in ("1", "true")
