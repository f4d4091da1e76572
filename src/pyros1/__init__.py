"""pyros1: ROS 1 as a Python package.

::

    import pyros1
    from pyros1.msgs.std_msgs.msg import Float64

    with pyros1.Node("minimal_publisher") as node:
        publisher = node.advertise("topic1", Float64, queue_size=1)
        rate = node.rate(1.0)
        message = Float64()
        while node.ok():
            message.data += 0.001
            publisher.publish(message)
            rate.sleep()

pytest does not rewrite the asserts of pyros1: PYTEST_DONT_REWRITE
"""

from __future__ import annotations

TYPE_CHECKING = False  # instead of typing.TYPE_CHECKING, so that small programs need not import typing
if TYPE_CHECKING:
    from typing import Any

    from pyros1.ground.errors import (
        ConnectionRefusedByPeerError,
        DeadlineError,
        DefinitionError,
        DeserializationError,
        Error,
        InvalidNameError,
        LaunchError,
        LengthError,
        MasterError,
        MasterMethodError,
        MasterUnreachableError,
        MessageError,
        NodeError,
        NodeShutdownError,
        PackageNotFoundError,
        ParameterNotSetError,
        ProtocolError,
        SerializationError,
        ServiceError,
        ServiceRefusal,
        ServiceUnavailableError,
        SettingError,
        TimeMovedBackwardsError,
        TransportError,
        UnknownHostError,
        UnknownTypeError,
        UnreachableError,
        WaitTimeoutError,
        XmlRpcFault,
    )
    from pyros1.ground.timing import Duration, Time
    from pyros1.msgs import AnyMsg
    from pyros1.node import Node
    from pyros1.node.subscribing.deadline import Missed
    from pyros1.node.watching.liveness import Sighting

from pyros1.ground import msgs_imports  # noqa: E402

msgs_imports.prepare_import()

from pyros1 import msgs  # noqa: E402, F401 - here, since several threads may import messages first

__version__ = "0.1.0"

__all__ = [
    "AnyMsg",
    "ConnectionRefusedByPeerError",
    "DeadlineError",
    "DefinitionError",
    "DeserializationError",
    "Duration",
    "Error",
    "InvalidNameError",
    "LaunchError",
    "LengthError",
    "MasterError",
    "MasterMethodError",
    "MasterUnreachableError",
    "MessageError",
    "Missed",
    "Node",
    "NodeError",
    "NodeShutdownError",
    "PackageNotFoundError",
    "ParameterNotSetError",
    "ProtocolError",
    "SerializationError",
    "ServiceError",
    "ServiceRefusal",
    "ServiceUnavailableError",
    "SettingError",
    "Sighting",
    "Time",
    "TimeMovedBackwardsError",
    "TransportError",
    "UnknownHostError",
    "UnknownTypeError",
    "UnreachableError",
    "WaitTimeoutError",
    "XmlRpcFault",
    "__version__",
]

_EXPORTS = {
    **dict.fromkeys(__all__, "pyros1.ground.errors"),
    "AnyMsg": "pyros1.msgs",
    "Duration": "pyros1.ground.timing",
    "Missed": "pyros1.node.subscribing.deadline",
    "Node": "pyros1.node",
    "Sighting": "pyros1.node.watching.liveness",
    "Time": "pyros1.ground.timing",
}


def __getattr__(name: str) -> Any:
    """Load a public name on first use and return it, so that small commands load only what they need."""
    from pyros1.ground.lazy import load  # noqa: PLC0415 - most imports never get here

    return load(__name__, _EXPORTS, name)


def __dir__() -> list[str]:
    """Return all public names, loaded or not, for completion."""
    from pyros1.ground.lazy import public_names  # noqa: PLC0415 - most imports never get here

    return public_names(globals(), __all__)
