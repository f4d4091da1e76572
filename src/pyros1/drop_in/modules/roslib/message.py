"""Classes of message and service types by name."""

from __future__ import annotations

from typing import Any

from genpy.message import Message, fill_message_args, get_printable_message_args, strify_message

from pyros1.ground.errors import MessageError
from pyros1.ground.generated import finder

__all__ = ["Message", "fill_message_args", "get_message_class", "get_printable_message_args", "strify_message"]


def get_message_class(message_type: str, reload_on_error: bool = False) -> Any:
    """Return the class of a message type; None if there is no definition."""
    if "/" not in message_type:
        raise ValueError(f"message type is missing package name: {message_type}")
    try:
        return finder().message(message_type)
    except MessageError:
        return None


def get_service_class(service_type: str, reload_on_error: bool = False) -> Any:
    """Return the class of a service type; None if there is no definition."""
    if "/" not in service_type:
        raise ValueError(f"service type is missing package name: {service_type}")
    try:
        return finder().service(service_type)
    except MessageError:
        return None
