"""Chooses file names for topics."""

from __future__ import annotations

import re

_ILLEGAL_CHARACTER_PATTERN = re.compile(r"[^\w.~-]", re.ASCII)


class TopicFileNames:
    """Unique file names for topics: ``robot1-odom`` for ``/robot1/odom``."""

    def __init__(self) -> None:
        self._names: dict[str, str] = {}

    def __getitem__(self, topic: str) -> str:
        name = self._names.get(topic)
        if name is None:
            base_name = _ILLEGAL_CHARACTER_PATTERN.sub("_", topic.strip("/").replace("/", "-")).lstrip(".") or "_"
            used_names = set(self._names.values())
            number = 2
            name = base_name
            while name in used_names:
                name, number = f"{base_name}_{number}", number + 1
            self._names[topic] = name
        return name
