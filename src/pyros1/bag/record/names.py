"""How recordings are called, and which topics are recorded. Pure."""

from __future__ import annotations

import re
import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from pyros1.errors import Error


@dataclass(frozen=True)
class FileNames:
    """The names of a recording's files (B17).

    Attributes:
        prefix: what they begin with; may have a folder, and the suffix ``.bag``.
        dated: whether the date follows.
        numbered: whether a number follows, counted from 0.
    """

    prefix: str = ""
    dated: bool = True
    numbered: bool = False

    def name(self, number: int, moment: float) -> str:
        """Return a file's name.

        Args:
            number: of the file.
            moment: when it is begun, in seconds since the epoch.
        """
        parts = [self.prefix.removesuffix(".bag")] if self.prefix else []
        if self.dated:
            parts.append(time.strftime("%Y-%m-%d-%H-%M-%S", time.localtime(moment)))
        if self.numbered:
            parts.append(str(number))
        return "_".join(parts) + ".bag"


@dataclass
class Selection:
    """Which topics are recorded (B15).

    Attributes:
        topics: full names, or regular expressions.
        regex: whether they are expressions; these must match the whole name.
        everything: record all.
        exclude: expression of those not to record, if found by `everything`, `regex` or `node`.
        node: record what this node subscribes to.

    Raises:
        Error: an expression is none.
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
        """Whether the master has to be asked again and again."""
        return self.everything or self.regex or bool(self.node)

    def named(self) -> list[str]:
        """Return the topics to record whether or not anybody publishes them."""
        return [] if self.regex else list(self.topics)

    def wants(self, topic: str, of_node: Collection[str] = ()) -> bool:
        """Return whether to record a topic that was found.

        Args:
            of_node: what `node` subscribes to.
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
