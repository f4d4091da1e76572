"""The slave API: the methods of a node that the master and other nodes call (https://wiki.ros.org/ROS/Slave_API;
S01-S13).

Runs on the loop. Every method returns ``[code, message, value]``; the code is -1 if the arguments are invalid.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, XmlRpcFault
from pyros1.net.hosts import parse_uri
from pyros1.node.log.levels import WARN
from pyros1.wire.handshake import Refusal
from pyros1.wire.local import LOCAL_PROTOCOL, is_offered

if TYPE_CHECKING:
    from pyros1.node.context import Context
    from pyros1.node.parameters.parameters import Parameters

_Response = list[Any]

_NAMESAKE_PATTERN = r"\[(/[^\]]*)\] Reason: new node registered with same name"
"""Matches the reason that the master gives when it shuts down a node that was replaced by a new one with the same name
(M34); the group is the name."""


class _BadArgumentError(Exception):
    """An argument is not valid for the method."""


class SlaveApi:
    """The methods of the slave API.

    Args:
        context: the node's context.
        master_uri: the URI that ``getMasterUri`` returns.
        get_tcpros_address: returns (host, port) of the node's TCPROS server.
        get_parameters: returns the node's `Parameters`, which processes updates of cached values.
        on_shutdown: called with the reason when a caller asks the node to shut down.
    """

    def __init__(
        self,
        context: Context,
        master_uri: str,
        get_tcpros_address: Callable[[], tuple[str, int]],
        get_parameters: Callable[[], Parameters],
        on_shutdown: Callable[[str], None],
    ) -> None:
        self._context = context
        self._master_uri = master_uri
        self._get_tcpros_address = get_tcpros_address
        self._get_parameters = get_parameters
        self._on_shutdown = on_shutdown
        self._methods: dict[str, tuple[Callable[..., _Response], int, int]] = {
            # name: (method, minimum and maximum number of arguments after the caller id)
            "getBusStats": (self._get_bus_stats, 0, 0),
            "getBusInfo": (self._get_bus_info, 0, 0),
            "getMasterUri": (self._get_master_uri, 0, 0),
            "getName": (self._get_name, 0, 0),
            "getUri": (self._get_uri, 0, 0),
            "getPid": (self._get_pid, 0, 0),
            "getSubscriptions": (self._get_subscriptions, 0, 0),
            "getPublications": (self._get_publications, 0, 0),
            "paramUpdate": (self._param_update, 2, 2),
            "publisherUpdate": (self._publisher_update, 2, 2),
            "requestTopic": (self._request_topic, 2, 2),
            "shutdown": (self._shutdown, 0, 1),
        }

    def dispatch(self, method: str, params: Sequence[Any]) -> _Response:
        """Execute a call and return its response.

        Raises:
            XmlRpcFault: there is no such method.
        """
        entry = self._methods.get(method)
        if entry is None:
            raise XmlRpcFault(1, f'method "{method}" is not supported')
        function, min_arguments, max_arguments = entry
        if not params:
            return [-1, "missing required caller_id parameter", 0]
        if not isinstance(params[0], str):
            return [-1, "caller_id must be a string", 0]
        if not min_arguments <= len(params) - 1 <= max_arguments:
            return [-1, "Error: bad call arity", 0]
        try:
            return function(*params[1:])
        except _BadArgumentError as error:
            return [-1, f"ERROR: {error}", 0]

    def _get_bus_stats(self) -> _Response:
        publications = [
            [topic, _to_xmlrpc_number(sum(link.bytes_sent for link in links)), [
                [index, _to_xmlrpc_number(link.bytes_sent), _to_xmlrpc_number(link.messages), link.connected]
                for index, link in enumerate(links)]]
            for topic, publication in self._context.publications.items()
            for links in [publication.links]
        ]  # fmt: skip
        subscriptions = [
            [
                topic,
                [
                    [index, _to_xmlrpc_number(_num_received_bytes(link)), _to_xmlrpc_number(link.messages), -1, True]
                    for index, link in enumerate(links)
                ],
            ]
            for topic, subscription in self._context.subscriptions.items()
            for links in [subscription.links]
        ]
        return [1, "", [publications, subscriptions, []]]

    def _get_bus_info(self) -> _Response:
        info: list[list[Any]] = []
        for topic, publication in self._context.publications.items():
            for link in publication.links:
                info.append([len(info), link.peer, "o", link.transport, topic, link.connected, link.address])
        for topic, subscription in self._context.subscriptions.items():
            for source in subscription.links:
                info.append([len(info), source.uri, "i", source.transport, topic, True, source.address])
        return [1, "", info]

    def _get_master_uri(self) -> _Response:
        return [1, self._master_uri, self._master_uri]

    def _get_name(self) -> _Response:
        return [1, "ROS node name", self._context.name]

    def _get_uri(self) -> _Response:
        return [1, self._context.uri, self._context.uri]

    def _get_pid(self) -> _Response:
        return [1, "", os.getpid()]

    def _get_subscriptions(self) -> _Response:
        return [1, "subscriptions", [[topic, sub.type.name] for topic, sub in self._context.subscriptions.items()]]

    def _get_publications(self) -> _Response:
        return [1, "publications", [[topic, pub.type.name] for topic, pub in self._context.publications.items()]]

    def _param_update(self, key: Any, value: Any) -> _Response:
        if not isinstance(key, str) or not key.startswith("/"):
            raise _BadArgumentError("parameter [parameter_key] must be a global name")
        return [1, "", 0] if self._get_parameters().update(key, value) else [-1, "not subscribed", 0]

    def _publisher_update(self, topic: Any, publishers: Any) -> _Response:
        if not isinstance(topic, str):
            raise _BadArgumentError("parameter [topic] must be a string")
        if not isinstance(publishers, list):
            raise _BadArgumentError("parameter [publishers] must be a list")
        subscription = self._context.subscriptions.get(topic)
        valid_uris, problem = [], ""  # one publisher with a wrong address must not affect the others
        for uri in publishers:
            if not isinstance(uri, str):
                problem = "publishers must be a list of strings"
            elif subscription is not None and subscription.has_publisher(uri):
                valid_uris.append(uri)  # checked in an earlier call; among thousands of URIs, often only one is new
            else:
                try:
                    parse_uri(uri)
                    valid_uris.append(uri)
                except Error as error:
                    problem = f"publishers: {error}"
        if subscription is not None:
            subscription.update_publishers(valid_uris)
            if problem:
                self._context.log.peer_event(WARN, "the master reports an invalid publisher of %s: %s", topic, problem)
        if problem:
            raise _BadArgumentError(problem)
        return [1, "", 0]

    def _request_topic(self, topic: Any, protocols: Any) -> _Response:
        if not isinstance(topic, str):
            raise _BadArgumentError("parameter [topic] must be a string")
        if not isinstance(protocols, list) or not protocols:
            return [-1, "ERROR: parameter [protocols] must be a list of protocols", []]
        if topic not in self._context.publications:
            return [-1, f"Not a publisher of [{topic}]", []]
        name = self._context.local_socket_name() if is_offered(protocols, self._context.local_key) else ""
        if name:
            return [1, f"ready on {name}", [LOCAL_PROTOCOL, name]]
        for protocol in protocols:
            if isinstance(protocol, list) and protocol and protocol[0] == "TCPROS":
                host, port = self._get_tcpros_address()
                return [1, f"ready on {host}:{port}", ["TCPROS", host, port]]
            if isinstance(protocol, list) and protocol and protocol[0] == "UDPROS":
                response = self._accept_udpros(topic, protocol)
                if response is not None:
                    return response
        return [0, "no supported protocol implementations", []]

    def _accept_udpros(self, topic: str, offer: list[Any]) -> _Response | None:
        """Add a link to a subscriber that has offered a socket for datagrams (T58, T59)."""
        from pyros1.wire.datagram import parse_udpros_offer  # noqa: PLC0415 - few nodes need it

        publication = self._context.publications[topic]
        try:
            requested = parse_udpros_offer(offer)
            if requested is None:
                return None
            link = publication.accept_datagrams(*requested)
        except (Refusal, Error) as refusal:
            self._context.log.peer_event(WARN, "refused a UDP subscriber of %s: %s", topic, refusal)
            return [0, str(refusal), 0]
        return [1, "", link.topic_response(self._get_tcpros_address()[0])]

    def _shutdown(self, reason: Any = "") -> _Response:
        if not isinstance(reason, str):
            raise _BadArgumentError("parameter [msg] must be a string")
        match = re.fullmatch(_NAMESAKE_PATTERN, reason)
        # The request is for a node that used our port before us: that node has exited, and was restarted elsewhere.
        if match is not None and match[1] != self._context.name:
            self._context.log.peer_event(WARN, "ignored a shutdown request that was intended for %s", match[1])
            return [1, "shutdown", 0]
        self._on_shutdown(reason)
        return [1, "shutdown", 0]


def _to_xmlrpc_number(number: int) -> float:
    """Convert a number of bytes or messages for XML-RPC, whose integers have 32 bits: larger numbers become floats."""
    return number if number < 1 << 31 else float(number)


def _num_received_bytes(link: Any) -> int:
    """Return the number of bytes received over a link; a link within the process only counts the bytes sent."""
    return int(getattr(link, "bytes_received", 0) or getattr(link, "bytes_sent", 0))
