"""Names as rmw_zenoh writes them: of types, topics and services, and the keys for their data. No I/O.

The messages of a topic, and the requests of a service, have the key ``DOMAIN/NAME/DDS TYPE/HASH``, for example
``0/chatter/std_msgs::msg::dds_::String_/RIHS01_df66...``. An action has no keys of its own: it has three services and
two topics below ``NAME/_action/``.
"""

from __future__ import annotations

import re
from typing import NamedTuple

from pyros1.ground.errors import InvalidNameError
from pyros1.ros2_types.model import NAME_PART, TYPE_NAME

HUMBLE_HASH = "TypeHashNotSupported"
"""The placeholder for a type's hash in ROS 2 Humble, which has no type hashes."""
ANY_HASH = "*"
"""Matches every hash, in the key of a subscriber."""
MAX_KEY_LENGTH = 1000
"""Longer keys are not parsed."""
MAX_DOMAIN = 0xFFFF_FFFF
"""The largest domain; DDS allows fewer."""
_MAX_NAME_LENGTH = 247
_NAME = re.compile(r"(?:/[A-Za-z_][A-Za-z0-9_]*)+", re.ASCII)
_DDS_TYPE = re.compile(rf"({NAME_PART})::(msg|srv|action)::dds_::({NAME_PART})_", re.ASCII)
_HASH = re.compile(r"[A-Za-z0-9_]{1,128}", re.ASCII)
_NUMBER = re.compile(r"[0-9]{1,20}", re.ASCII)


class DataKey(NamedTuple):
    """The key of a topic's messages, or of a service's requests.

    Attributes:
        domain: ROS domain, by default 0.
        name: name of the topic or service, for example ``/chatter``.
        type: name of its type, for example ``std_msgs/msg/String`` or ``std_srvs/srv/SetBool``.
        hash: the hash of its type; HUMBLE_HASH; or, in the key of a subscriber, ANY_HASH.
    """

    domain: int
    name: str
    type: str
    hash: str


def is_full_name(name: str) -> bool:
    """Return whether this is a legal full name of a ROS 2 topic, service or namespace (other than ``/``)."""
    return len(name) <= _MAX_NAME_LENGTH and _NAME.fullmatch(name) is not None


def is_hash(text: str) -> bool:
    """Return whether this can be a type's hash, or the placeholder that Humble uses instead."""
    return _HASH.fullmatch(text) is not None


def dds_type(name: str) -> str:
    """Return the DDS name of a type: ``std_msgs::msg::dds_::String_`` for ``std_msgs/msg/String``.

    Parts of actions have types, too, such as ``example_interfaces/action/Fibonacci_SendGoal``.

    Raises:
        InvalidNameError: it is not the name of a type.
    """
    match = TYPE_NAME.fullmatch(name)
    if match is None:
        raise InvalidNameError(f"'{name:.200}' is not the name of a ROS 2 type, such as std_msgs/msg/String")
    package, kind, short = match.groups()
    return f"{package}::{kind}::dds_::{short}_"


def type_of_dds(name: str) -> str | None:
    """Return the ROS 2 type that has a DDS name; None if there can be none."""
    match = _DDS_TYPE.fullmatch(name)
    return None if match is None else "/".join(match.groups())


def data_key(key: DataKey) -> str:
    """Return a key as text.

    Raises:
        InvalidNameError: the name, type or hash is not legal, or the domain is out of range.
    """
    check_domain(key.domain)
    if not is_full_name(key.name):
        raise InvalidNameError(f"'{key.name:.300}' is not a legal full name of a topic or service in ROS 2")
    if key.hash != ANY_HASH and not is_hash(key.hash):
        raise InvalidNameError(f"'{key.hash:.200}' is not the hash of a type")
    return f"{key.domain}{key.name}/{dds_type(key.type)}/{key.hash}"


def parse_data_key(text: str) -> DataKey | None:
    """Parse another program's key; None if it is not valid, or longer than MAX_KEY_LENGTH."""
    parts = text.rsplit("/", 2) if len(text) <= MAX_KEY_LENGTH else ()
    if len(parts) != 3:
        return None
    start, slash, name = parts[0].partition("/")
    domain = read_number(start, MAX_DOMAIN)
    type_name = type_of_dds(parts[1])
    if domain is None or type_name is None or not is_full_name(slash + name) or not is_hash(parts[2]):
        return None
    return DataKey(domain, slash + name, type_name, parts[2])


def check_domain(domain: int) -> None:
    """Check that a domain is in range.

    Raises:
        InvalidNameError: it is not.
    """
    if not 0 <= domain <= MAX_DOMAIN:
        raise InvalidNameError(f"{domain} is not a ROS domain")


def read_number(text: str, maximum: int) -> int | None:
    """Parse a number in decimal digits; None if it is not one, or more than `maximum`."""
    number = int(text) if _NUMBER.fullmatch(text) else None
    return None if number is None or number > maximum else number
