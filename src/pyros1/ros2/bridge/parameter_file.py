"""Reads the parameters of ros1_bridge's parameter_bridge: which topics and services it exchanges
(https://github.com/ros2/ros1_bridge#example-4-bridge-only-selected-topics-and-services).

A file has any of these lists; other parameters are ignored::

    topics:
    - {topic: /chatter, type: std_msgs/msg/String, queue_size: 1}
    services_1_to_2:
    - {service: /add_two_ints, type: example_interfaces/srv/AddTwoInts}
    services_2_to_1:
    - {service: /clear, type: std_srvs/Empty}

ros1_bridge's documentation and code disagree about which list is for which side's services, so both lists are treated
alike: each service is called on the side that provides it. The types are the nodes' types, whatever the file says.
"""

from __future__ import annotations

import os
from typing import NamedTuple

from pyros1.bridge.names import SiteNameError
from pyros1.bridge.rules.file_reader import FileReader, RulesError
from pyros1.ros2.zenoh.names import is_full_name

MAX_SIZE = 1 << 20
"""Maximum size of a file in characters."""
_LISTS = {"topics": "topic", "services_1_to_2": "service", "services_2_to_1": "service"}
_KEYS = {"topic": ("topic", "type", "queue_size", "qos"), "service": ("service", "type", "package")}


class BridgeParameters(NamedTuple):
    """The contents of a parameter file.

    Attributes:
        names: the names of topics and services that may be exchanged, in both directions.
        notes: the settings that the bridge ignores, with file and line.
    """

    names: list[str]
    notes: list[str]


def read_parameters(path: str | os.PathLike[str]) -> BridgeParameters:
    """Read a parameter file.

    Raises:
        OSError: the file cannot be read.
        YamlError: it is not YAML.
        RulesError: it has none of the lists, or one is not valid; the error names file and line.
    """
    with open(path, encoding="utf-8", errors="replace") as file:
        text = file.read(MAX_SIZE + 1)
    if len(text) > MAX_SIZE:
        raise RulesError(f"{path}: it is larger than {MAX_SIZE} characters")
    return _ParameterFile(text, os.fspath(path)).read()


class _ParameterFile(FileReader):
    def read(self) -> BridgeParameters:
        """Return the contents of the file."""
        found = BridgeParameters([], [])
        file = self._mapping(self._value, (), None)
        for key, kind in _LISTS.items():
            for item, path in self._items(file, key):
                fields = self._mapping(item, path, _KEYS[kind])
                if kind not in fields:
                    self._fail(path, f"{kind} is missing")
                name = self._checked((*path, kind), _check_name, self._text(fields[kind], (*path, kind)))
                found.names.append(name)
                if "qos" in fields:
                    place = self._place((*path, "qos"))
                    found.notes.append(f"{place}: qos is not used: for {name}, it follows from what the nodes offer")
        if not found.names:
            self._fail((), f"it has none of the lists {', '.join(_LISTS)}")
        return found


def _check_name(text: str) -> str:
    """Return a name with a leading slash.

    Raises:
        SiteNameError: it is not a name.
    """
    name = text if text.startswith("/") else f"/{text}"
    if not is_full_name(name):
        raise SiteNameError(f"{text!r:.80} is not the name of a topic or service")
    return name
