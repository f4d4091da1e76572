"""Messages and services: turns definitions into Python classes with the same interface as genpy's classes.

::

    from pyros1.msgs.geometry_msgs.msg import Twist       # classes are made when they are imported
    from pyros1.msgs.std_srvs.srv import Trigger, TriggerResponse
    cls = load_message("sensor_msgs/Image")               # the same class, by name
    cls = from_definition(header["type"], header["message_definition"])  # no definition files needed

Definitions are taken from packages on ROS_PACKAGE_PATH, from stock ROS installations, and from the definitions shipped
with pyros1.
"""

from __future__ import annotations

from pyros1.ground import msgs_imports

TYPE_CHECKING = False  # in place of typing.TYPE_CHECKING: small programs need not load typing
if TYPE_CHECKING:
    from typing import Any

    from pyros1.msgs.base import AnyMsg, Message, Service
    from pyros1.msgs.definition_cache import DefinitionCache
    from pyros1.msgs.dynamic import from_definition
    from pyros1.msgs.records import record_dtype

__path__ = msgs_imports.make_search_path(__path__)


def load_message(type_name: str) -> type[Message]:
    """Return the class of a message type.

    Args:
        type_name: ``package/Type``.

    Raises:
        UnknownTypeError: no definition was found.
        DefinitionError: the definition is invalid; the message names the file and the line.
    """
    cls: type[Message] = msgs_imports.finder().message(type_name)
    return cls


def load_service(type_name: str) -> type[Service]:
    """Return the class of a service type; arguments and errors as for :func:`load_message`."""
    cls: type[Service] = msgs_imports.finder().service(type_name)
    return cls


__all__ = [
    "AnyMsg",
    "DefinitionCache",
    "Message",
    "Service",
    "from_definition",
    "load_message",
    "load_service",
    "record_dtype",
]


_EXPORTS = {
    **dict.fromkeys(("AnyMsg", "Message", "Service"), "pyros1.msgs.base"),
    "DefinitionCache": "pyros1.msgs.definition_cache",
    "from_definition": "pyros1.msgs.dynamic",
    "record_dtype": "pyros1.msgs.records",
}


if not TYPE_CHECKING:  # so that type checkers report names that do not exist

    def __getattr__(name: str) -> Any:
        """Import a public name on first use, and return it: every program that uses pyros1 imports this package."""
        from pyros1.ground.lazy import load  # noqa: PLC0415 - most imports never get here

        return load(__name__, _EXPORTS, name)


def __dir__() -> list[str]:
    """Return the public names, and the packages that contain definitions, for completion."""
    packages = map(msgs_imports.module_name, msgs_imports.finder().library.packages())
    return sorted({*globals(), *__all__, *packages})
