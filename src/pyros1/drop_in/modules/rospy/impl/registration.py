"""The managers of the program's topics and services."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.module_attributes import module_hooks as _module_hooks


class Registration:
    """The kinds of registration with the master."""

    PUB = "pub"
    SUB = "sub"
    SRV = "srv"


def get_topic_manager() -> Any:
    """Return the object that lists the program's topics."""
    from rospy.topics import TOPICS

    return TOPICS


def get_service_manager() -> Any:
    """Return the object that lists the program's services."""
    from rospy.service import SERVICES

    return SERVICES


_reason = "pyros1's nodes register themselves"
_missing_names = ("RegManager", "RegistrationListener", "RegistrationListeners", "get_registration_listeners")
__getattr__, __dir__ = _module_hooks(
    __name__, missing_reasons=dict.fromkeys((*_missing_names, "set_topic_manager", "set_service_manager"), _reason)
)
