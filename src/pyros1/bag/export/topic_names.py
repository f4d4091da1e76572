"""File names for topics."""

from __future__ import annotations

import re

_STRANGE = re.compile(r"[^\w.~-]", re.ASCII)


class FileNames:
    """Unique file names for topics: ``robot1-odom`` for ``/robot1/odom``."""

    def __init__(self) -> None:
        self._names: dict[str, str] = {}

    def __getitem__(self, topic: str) -> str:
        name = self._names.get(topic)
        if name is None:
            plain = _STRANGE.sub("_", topic.strip("/").replace("/", "-")).lstrip(".") or "_"
            taken = set(self._names.values())
            number = 2
            name = plain
            while name in taken:
                name, number = f"{plain}_{number}", number + 1
            self._names[topic] = name
        return name
