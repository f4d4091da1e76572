"""A ROS 2 node that has parameters, at the side of `Ros2Peer`; its messages are encoded by rosbags, not by us."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from pyros1.ros2.bridge.parameters.messages import EVENT_TYPE, SERVICE_TYPES
from pyros1.ros2.zenoh.calls import IncomingCall
from pyros1.ros2.zenoh.names import DataKey

from ..test_running import Ros2Peer

HASHES = {
    "list_parameters": "RIHS01_3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d",
    "describe_parameters": "RIHS01_845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff",
    "get_parameters": "RIHS01_bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc",
    "set_parameters": "RIHS01_56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0",
}
"""As ROS 2 Kilted has them."""
EVENT_HASH = "RIHS01_043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204"
"""The same."""
EVENTS = DataKey(0, "/parameter_events", EVENT_TYPE, EVENT_HASH)
_TEXTS = {
    "ListParameters": ("string[] prefixes\nuint64 depth\n", "rcl_interfaces/msg/ListParametersResult result\n"),
    "DescribeParameters": ("string[] names\n", "rcl_interfaces/msg/ParameterDescriptor[] descriptors\n"),
    "GetParameters": ("string[] names\n", "rcl_interfaces/msg/ParameterValue[] values\n"),
    "SetParameters": (
        "rcl_interfaces/msg/Parameter[] parameters\n",
        "rcl_interfaces/msg/SetParametersResult[] results\n",
    ),
}
KINDS = (
    "",
    "bool",
    "integer",
    "double",
    "string",
    "byte_array",
    "bool_array",
    "integer_array",
    "double_array",
    "string_array",
)


def _kind(value: Any) -> int:
    if value is None:
        return 0
    if isinstance(value, bytes):
        return 5
    kinds = [bool, int, float, str]
    return 6 + kinds.index(type(value[0])) if isinstance(value, list) else 1 + kinds.index(type(value))


class Encoding:
    """What rosbags makes of rcl_interfaces."""

    def __init__(self) -> None:
        self.store: Any = get_typestore(Stores.ROS2_KILTED)
        for name, (request, response) in _TEXTS.items():
            for part, text in (("Request", request), ("Response", response)):
                self.store.register(get_types_from_msg(text, f"rcl_interfaces/msg/{name}_{part}"))

    def make(self, name: str, *fields: Any) -> Any:
        return self.store.types[f"rcl_interfaces/{name}"](*fields)

    def encode(self, message: Any) -> bytes:
        return bytes(self.store.serialize_cdr(message, message.__msgtype__))

    def value(self, value: Any, kind: int | None = None) -> Any:
        kind = _kind(value) if kind is None else kind
        fields: list[Any] = [False, 0, 0.0, ""]
        fields += [np.array([], np.uint8), np.array([], bool), np.array([], np.int64), np.array([], np.float64), []]
        if kind in range(1, 10):
            if isinstance(value, bytes):
                value = np.frombuffer(value, np.uint8)
            elif 6 <= kind <= 8:
                value = np.array(value, fields[kind - 1].dtype)
            fields[kind - 1] = value
        return self.make("msg/ParameterValue", kind, *fields)

    def read(self, value: Any) -> Any:
        return getattr(value, f"{KINDS[value.type]}_value")

    def descriptor(self, name: str, said: Mapping[str, Any], value: Any) -> Any:
        integers = [self.make("msg/IntegerRange", *said["integers"], 0)] if "integers" in said else []
        doubles = [self.make("msg/FloatingPointRange", *said["doubles"], 0.0)] if "doubles" in said else []
        return self.make(
            "msg/ParameterDescriptor",
            name,
            _kind(value),
            said.get("text", ""),
            said.get("constraints", ""),
            said.get("read_only", False),
            False,
            doubles,
            integers,
        )

    def event(self, node: str, new: Mapping[str, Any], changed: Mapping[str, Any], deleted: Mapping[str, Any]) -> bytes:
        parts = [
            [self.make("msg/Parameter", name, self.value(value)) for name, value in each.items()]
            for each in (new, changed, deleted)
        ]
        stamp = self.store.types["builtin_interfaces/msg/Time"](1, 2)
        return self.encode(self.make("msg/ParameterEvent", stamp, node, *parts))


class FakeNode:
    """A node with parameters.

    Attributes:
        values, said: the parameters, and what their descriptors say.
        refuse: returns why a value is not set; empty to set it.
        hooks: service -> what responds in place of the usual, given the request; None for no response.
        asked: what was asked for, in order.
    """

    def __init__(
        self,
        peer: Ros2Peer,
        name: str,
        values: Mapping[str, Any],
        said: Mapping[str, Mapping[str, Any]] | None = None,
        hashes: Mapping[str, str] = HASHES,
    ) -> None:
        self.peer, self.name = peer, name
        self.values, self.said = dict(values), dict(said or {})
        self.refuse: Callable[[str, Any], str] = lambda name, value: ""
        self.hooks: dict[str, Callable[[Any], Any]] = {}
        self.asked: list[str] = []
        self.encoding = Encoding()
        self.publishes_events = True
        peer.publish(EVENTS)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()
        for service, type in SERVICE_TYPES.items():
            peer.offer(DataKey(0, f"{name}/{service}", type, hashes[service]))

    def _serve(self) -> None:
        while not self._ended.is_set():
            try:
                call = self.peer.calls.get(timeout=0.05)
            except queue.Empty:
                continue
            self._answer(call)

    def _answer(self, call: IncomingCall) -> None:
        node, _, service = call.key.name.rpartition("/")
        assert node == self.name
        self.asked.append(service)
        short = call.key.type.rpartition("/")[2]
        request = self.encoding.store.deserialize_cdr(call.body, f"rcl_interfaces/msg/{short}_Request")
        response = self.hooks.get(service, getattr(self, f"_{service}"))(request)
        if response is None:
            call.drop()
        elif isinstance(response, bytes):
            call.respond(response)
        else:
            call.respond(self.encoding.encode(self.encoding.make(f"msg/{short}_Response", response)))

    def _list_parameters(self, request: Any) -> Any:
        return self.encoding.make("msg/ListParametersResult", [*self.values], [])

    def _describe_parameters(self, request: Any) -> Any:
        return [
            self.encoding.descriptor(name, self.said.get(name, {}), self.values.get(name)) for name in request.names
        ]

    def _get_parameters(self, request: Any) -> Any:
        return [self.encoding.value(self.values.get(name)) for name in request.names]

    def _set_parameters(self, request: Any) -> Any:
        results = []
        for each in request.parameters:
            value = self.encoding.read(each.value)
            reason = self.refuse(each.name, value)
            if not reason:
                self.change(each.name, value)
            results.append(self.encoding.make("msg/SetParametersResult", not reason, reason))
        return results

    def change(self, name: str, value: Any) -> None:
        """Set a parameter, and say so."""
        self.values[name] = value
        if self.publishes_events:
            self.say(changed={name: value})

    def say(
        self, new: Mapping[str, Any] = {}, changed: Mapping[str, Any] = {}, deleted: Mapping[str, Any] = {}
    ) -> None:
        """Publish which parameters have changed."""
        self.peer.send(EVENTS, self.encoding.event(self.name, new, changed, deleted))

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
