"""Creates the WebSocket frames sent to viewers (no I/O)."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum
from typing import Any

from pyros1.web.foxglove.offers import Channel, Nodes, Service
from pyros1.web.server.sending import LargeFrame

Frame = str | bytes
_LARGE_BYTES = 64 << 10
"""Size in bytes above which messages are not copied."""
ENCODINGS = ("ros1", "json")
"""Encodings that viewers may use for messages and service requests."""
_MESSAGE_HEADER = struct.Struct("<BIQ")
_MAX_TIME = (1 << 64) - 1


class Level(IntEnum):
    """The severity of a status message."""

    INFO = 0
    WARNING = 1
    ERROR = 2


def server_info(name: str, capabilities: Sequence[str], session: str, metadata: Mapping[str, str]) -> Frame:
    """Return the first frame for a viewer, which describes the server."""
    return _dumps(
        {
            "op": "serverInfo",
            "name": name,
            "capabilities": list(capabilities),
            "supportedEncodings": list(ENCODINGS),
            "metadata": dict(metadata),
            "sessionId": session,
        }
    )


def status(level: Level, text: str, id: str | None = None) -> Frame:
    """Return the frame that shows a status message to the user, in place of any earlier one with the same id."""
    return _dumps({"op": "status", "level": int(level), "message": text, **({} if id is None else {"id": id})})


def remove_status(ids: Iterable[str]) -> Frame:
    """Return the frame that removes status messages."""
    return _dumps({"op": "removeStatus", "statusIds": list(ids)})


def advertise(channels: Iterable[Channel]) -> Frame:
    """Return the frame that announces channels."""
    return _dumps(
        {
            "op": "advertise",
            "channels": [
                {
                    "id": each.id,
                    "topic": each.topic,
                    "encoding": "ros1",
                    "schemaName": each.type,
                    "schema": each.schema,
                    "schemaEncoding": "ros1msg",
                }
                for each in channels
            ],
        }
    )


def unadvertise(ids: Iterable[int]) -> Frame:
    """Return the frame that removes channels."""
    return _dumps({"op": "unadvertise", "channelIds": list(ids)})


def advertise_services(services: Iterable[Service]) -> Frame:
    """Return the frame that announces services."""

    def part(schema_name: str, schema: str) -> dict[str, str]:
        return {"encoding": "ros1", "schemaName": schema_name, "schemaEncoding": "ros1msg", "schema": schema}

    return _dumps(
        {
            "op": "advertiseServices",
            "services": [
                {
                    "id": each.id,
                    "name": each.name,
                    "type": each.type,
                    "request": part(f"{each.type}_Request", each.request),
                    "response": part(f"{each.type}_Response", each.response),
                    "requestSchema": each.request,  # viewers from 2023 or earlier know only these
                    "responseSchema": each.response,
                }
                for each in services
            ],
        }
    )


def unadvertise_services(ids: Iterable[int]) -> Frame:
    """Return the frame that removes services."""
    return _dumps({"op": "unadvertiseServices", "serviceIds": list(ids)})


def message(subscription: int, time: int, payload: bytes) -> bytes | LargeFrame:
    """Return the frame that delivers a message on a topic.

    Args:
        subscription: the id that the viewer has given to the subscription.
        time: time of reception in nanoseconds.
        payload: the serialized message.
    """
    header = _MESSAGE_HEADER.pack(1, subscription, time)
    if len(payload) <= _LARGE_BYTES:
        return header + payload
    return LargeFrame((header, payload), len(header) + len(payload), is_text=False)


def time(now: int) -> Frame:
    """Return the frame that tells viewers the time.

    Args:
        now: the time in nanoseconds.
    """
    return struct.pack("<BQ", 2, now)


def nanoseconds(seconds: float) -> int:
    """Convert a time in seconds to the nanoseconds used in frames, within their range."""
    return min(max(0, int(seconds * 1e9)), _MAX_TIME)


def parameter_values(parameters: Sequence[Mapping[str, Any]], id: str | None = None) -> Frame:
    """Return the frame with the values of parameters.

    Args:
        parameters: the parameters; see `pyros1.web.foxglove.parameters.entry`.
        id: the id of the request; None if the viewer did not request the values.
    """
    return _dumps(
        {"op": "parameterValues", "parameters": list(parameters), **({} if id is None else {"id": id})},
    )


def service_response(service: int, call: int, encoding: str, payload: bytes) -> Frame:
    """Return the frame with the response to a service call."""
    name = encoding.encode()
    return struct.pack("<BIII", 3, service, call, len(name)) + name + payload


def service_failure(service: int, call: int, text: str) -> Frame:
    """Return the frame that says why a service call failed."""
    return _dumps({"op": "serviceCallFailure", "serviceId": service, "callId": call, "message": text})


def asset(request: int, data: bytes) -> Frame:
    """Return the frame with the contents of a requested file."""
    return struct.pack("<BIBI", 4, request, 0, 0) + data


def asset_failure(request: int, text: str) -> Frame:
    """Return the frame that says why a requested file cannot be sent."""
    reason = text.encode(errors="replace")
    return struct.pack("<BIBI", 4, request, 1, len(reason)) + reason


def graph_update(previous: Nodes, current: Nodes) -> Frame | None:
    """Return the frame with the changes in the graph of nodes; None if there are none."""
    published, subscribed, services = (
        [(name, list(nodes)) for name, nodes in new.items() if old.get(name) != nodes]
        for old, new in zip(previous, current, strict=True)
    )
    # A topic that has lost all its publishers but still has subscribers is not removed: its list of publishers is sent
    # empty.
    topics = {*current[0], *current[1]}
    for changed, old, new in ((published, previous[0], current[0]), (subscribed, previous[1], current[1])):
        changed += [(name, []) for name in old if name not in new and name in topics]
    removed_topics = sorted({*previous[0], *previous[1]} - topics)
    removed_services = sorted({*previous[2]} - {*current[2]})
    if not (published or subscribed or services or removed_topics or removed_services):
        return None
    return _dumps(
        {
            "op": "connectionGraphUpdate",
            "publishedTopics": [{"name": name, "publisherIds": nodes} for name, nodes in published],
            "subscribedTopics": [{"name": name, "subscriberIds": nodes} for name, nodes in subscribed],
            "advertisedServices": [{"name": name, "providerIds": nodes} for name, nodes in services],
            "removedTopics": removed_topics,
            "removedServices": removed_services,
        }
    )


_dumps = json.JSONEncoder(ensure_ascii=True, allow_nan=False, separators=(",", ":")).encode
