"""Reads lists of sources, from which nodes select velocity commands."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.robot_nodes.shared.parameters import is_number


class SourceError(Error):
    """A list of sources cannot be used."""


@dataclass(frozen=True)
class Source:
    """A topic with commands, or one that locks others.

    Attributes:
        name: the source's name in logs and in messages to other nodes.
        topic: the source's topic.
        timeout: how many seconds a message is valid.
        priority: the source with the highest priority drives the robot.
    """

    name: str
    topic: str
    timeout: float
    priority: int


def read_sources(value: Any, where: str, max_priority: int = 2**32 - 1) -> list[Source]:
    """Return the sources in a list of mappings with name, topic, timeout and priority.

    Args:
        value: the list.
        where: the name of the list, for errors.
        max_priority: the highest allowed priority.

    Raises:
        SourceError: the value is invalid. Ignoring parts of it would be dangerous.
    """
    if not isinstance(value, list):
        raise SourceError(f"{where} must be a list, not {_text(value)}")
    return [_read_source(entry, f"{where}[{index}]", max_priority) for index, entry in enumerate(value)]


def _read_source(entry: Any, where: str, max_priority: int) -> Source:
    if not isinstance(entry, Mapping):
        raise SourceError(f"{where} must have name, topic, timeout and priority, but is {_text(entry)}")
    name, topic, timeout, priority = (entry.get(key) for key in ("name", "topic", "timeout", "priority"))
    if not isinstance(name, str):
        raise SourceError(f"{where} needs a name, a string, not {_text(name)}")
    if not isinstance(topic, str) or not topic:
        raise SourceError(f"{where} ({name}) needs a topic, a string, not {_text(topic)}")
    if not is_number(timeout) or timeout < 0:
        raise SourceError(f"{where} ({name}) needs a timeout, a number of at least 0, not {_text(timeout)}")
    if not is_number(priority) or not 0 <= priority <= max_priority or priority != int(priority):
        raise SourceError(
            f"{where} ({name}) needs a priority, an integer from 0 to {max_priority}, not {_text(priority)}"
        )
    return Source(name, topic, float(timeout), int(priority))


def _text(value: object) -> str:
    return one_line(repr(value), 100)
