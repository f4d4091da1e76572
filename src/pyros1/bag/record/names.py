"""Names of recordings, and the choice of topics to record. Pure."""

from __future__ import annotations

import re
import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from pyros1.ground.errors import Error


@dataclass(frozen=True)
class FileNames:
    """The names of a recording's files (B17).

    Attributes:
        prefix: the beginning of the names; may contain a folder, and the suffix ``.bag``.
        dated: whether the date follows.
        numbered: whether a number follows, counted from 0.
    """

    prefix: str = ""
    dated: bool = True
    numbered: bool = False

    def name(self, number: int, moment: float) -> str:
        """Return a file's name.

        Args:
            number: number of the file.
            moment: time at which it begins, in seconds since the epoch.
        """
        parts = [self.prefix.removesuffix(".bag")] if self.prefix else []
        if self.dated:
            parts.append(time.strftime("%Y-%m-%d-%H-%M-%S", time.localtime(moment)))
        if self.numbered:
            parts.append(str(number))
        return "_".join(parts) + ".bag"


@dataclass
class Selection:
    """Choice of the topics to record (B15).

    Attributes:
        topics: full names, or regular expressions.
        regex: whether they are expressions, which must match the whole name.
        everything: whether to record all topics.
        exclude: expression for topics to leave out of those found by `everything`, `regex` or `node`.
        node: name of a node whose subscribed topics to record.

    Raises:
        Error: an expression is not valid.
    """

    topics: Sequence[str] = ()
    regex: bool = False
    everything: bool = False
    exclude: str = ""
    node: str = ""
    _patterns: list[re.Pattern[str]] = field(init=False, default_factory=list)
    _exclude: re.Pattern[str] | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        if self.regex:
            self._patterns = [_compile(topic) for topic in self.topics]
        if self.exclude:
            self._exclude = _compile(self.exclude)

    @property
    def polling(self) -> bool:
        """Whether the master must be asked repeatedly."""
        return self.everything or self.regex or bool(self.node)

    def named(self) -> list[str]:
        """Return the topics to record even if they have no publisher."""
        return [] if self.regex else list(self.topics)

    def wants(self, topic: str, of_node: Collection[str] = ()) -> bool:
        """Return whether to record a discovered topic.

        Args:
            of_node: the topics that `node` subscribes to.
        """
        if self._exclude is not None and self._exclude.fullmatch(topic):
            return False
        if self.everything or topic in of_node:
            return True
        return any(pattern.fullmatch(topic) for pattern in self._patterns)


def _compile(expression: str) -> re.Pattern[str]:
    try:
        return re.compile(expression)
    except re.error as error:
        raise Error(f"{expression!r} is not a regular expression: {error}") from None
