"""A ROS 2 node with parameters, written with zenoh-ros2-sdk, which encodes its messages by the rosbags library.

`python ros2_sdk_parameters_peer.py PORT` is the node ``/ros2_camera`` with the parameters ``rate`` (an integer from 1
to 9, which must be odd), ``gains.p``, ``frame``, ``use_sim_time`` and the array ``limits``. A line ``rate 3`` of its
input sets ``rate`` in ROS 2. It prints what is set from outside, and ends with its input.
"""

from __future__ import annotations

import sys
from typing import Any

import numpy
import zenoh_ros2_sdk as sdk
from rosbags.typesys import Stores, get_typestore

NAME = "/ros2_camera"
RCL = "rcl_interfaces/msg/"
SERVICES = {
    "ListParameters": (
        "string[] prefixes\nuint64 depth\n",
        f"{RCL}ListParametersResult result\n",
        "RIHS01_3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d",
    ),
    "DescribeParameters": (
        "string[] names\n",
        f"{RCL}ParameterDescriptor[] descriptors\n",
        "RIHS01_845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff",
    ),
    "GetParameters": (
        "string[] names\n",
        f"{RCL}ParameterValue[] values\n",
        "RIHS01_bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc",
    ),
    "SetParameters": (
        f"{RCL}Parameter[] parameters\n",
        f"{RCL}SetParametersResult[] results\n",
        "RIHS01_56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0",
    ),
}
EVENT_HASH = "RIHS01_043e627780fcad87a22d225bc2a037361dba713fca6a6b9f4b869a5aa0393204"
EVENT = (
    f"builtin_interfaces/msg/Time stamp\nstring node\n{RCL}Parameter[] new_parameters\n"
    f"{RCL}Parameter[] changed_parameters\n{RCL}Parameter[] deleted_parameters\n"
)
FIELDS = {bool: (1, "bool_value"), int: (2, "integer_value"), float: (3, "double_value"), str: (4, "string_value")}


class Camera:
    """The node."""

    def __init__(self, port: int) -> None:
        self.values: dict[str, Any] = {
            "rate": 5,
            "gains.p": 1.5,
            "frame": "map",
            "use_sim_time": False,
            "limits": [1.0, 2.5],
        }
        router: dict[str, Any] = {"router_ip": "127.0.0.1", "router_port": port}
        known = get_typestore(Stores.ROS2_JAZZY)
        self.types = sdk.session.ZenohSession.get_instance(**router).store
        self.types.register(
            {name: each for name, each in known.fielddefs.items() if name.startswith((RCL, "builtin_interfaces/"))}
        )
        how = {"node_name": NAME[1:], **router}
        self.events = sdk.ROS2Publisher(
            "/parameter_events", f"{RCL}ParameterEvent", msg_definition=EVENT, type_hash=EVENT_HASH, **how
        )
        self.servers = [self.serve(short, *SERVICES[short], how) for short in SERVICES]

    def serve(self, short: str, request: str, response: str, type_hash: str, how: dict[str, Any]) -> Any:
        """Offer a service."""
        words = {"Get": self.get, "Set": self.set, "List": self.list, "Describe": self.describe}
        answer = words[short.removesuffix("Parameters")]
        server = sdk.ROS2ServiceServer(
            f"{NAME}/{short.removesuffix('Parameters').lower()}_parameters",
            f"rcl_interfaces/srv/{short}",
            lambda received: server.response_msg_class(answer(received)),
            request_definition=request,
            response_definition=response,
            type_hash=type_hash,
            **how,
        )
        return server

    def make(self, name: str, *fields: Any) -> Any:
        """Return a message."""
        return self.types.types[RCL + name](*fields)

    def value(self, value: Any) -> Any:
        """Return a ParameterValue."""
        empty = [numpy.array([], kind) for kind in (numpy.int8, bool, numpy.int64, numpy.float64)]
        message = self.make("ParameterValue", 0, False, 0, 0.0, "", *empty, [])
        if isinstance(value, list):
            message.type, message.double_array_value = 8, numpy.array(value)
        else:
            message.type, field = FIELDS[type(value)]
            setattr(message, field, value)
        return message

    def list(self, _: Any) -> Any:
        """Answer a request for names."""
        return self.make("ListParametersResult", [*self.values], [])

    def describe(self, request: Any) -> Any:
        """Answer a request for descriptors."""
        limits = [self.make("IntegerRange", 1, 9, 0)]
        return [
            self.make("ParameterDescriptor", name, 0, f"the {name}", "", False, False, [], limits * (name == "rate"))
            for name in request.names
        ]

    def get(self, request: Any) -> Any:
        """Answer a request for values."""
        return [self.value(self.values[name]) for name in request.names]

    def set(self, request: Any) -> Any:
        """Answer a request to set parameters."""
        results = []
        for each in request.parameters:
            value = getattr(each.value, dict(FIELDS.values())[each.value.type])
            reason = "it must be odd" if each.name == "rate" and value % 2 == 0 else ""
            if not reason:
                self.change(each.name, value)
                print("set", each.name, value, flush=True)
            results.append(self.make("SetParametersResult", not reason, reason))
        return results

    def change(self, name: str, value: Any) -> None:
        """Set a parameter, and tell everybody."""
        self.values[name] = value
        stamp = self.types.types["builtin_interfaces/msg/Time"](0, 0)
        changed = [self.make("Parameter", name, self.value(value))]
        self.events.publish(
            stamp=stamp, node=NAME, new_parameters=[], changed_parameters=changed, deleted_parameters=[]
        )


def main() -> None:
    """Run until the input ends."""
    camera = Camera(int(sys.argv[1]))
    print("ready", flush=True)
    for line in sys.stdin:
        camera.change(line.split()[0], int(line.split()[1]))
    for end in (*camera.servers, camera.events):
        end.close()


if __name__ == "__main__":
    main()
