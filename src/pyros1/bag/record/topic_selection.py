"""The selection of topics to record. Does no I/O."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from pyros1.ground.errors import Error


@dataclass
class TopicSelection:
    """The topics to record (B15).

    Attributes:
        topics: full names, or regular expressions.
        uses_regex: whether `topics` are regular expressions, which must match the whole name.
        all_topics: whether to record all topics.
        exclude: regular expression for topics to leave out although `all_topics`, `uses_regex` or `node` selects them.
        node: name of a node; the topics to which it subscribes are recorded.

    Raises:
        Error: a regular expression is not valid.
    """

    topics: Sequence[str] = ()
    uses_regex: bool = False
    all_topics: bool = False
    exclude: str = ""
    node: str = ""
    _patterns: list[re.Pattern[str]] = field(init=False, default_factory=list)
    _exclude: re.Pattern[str] | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        if self.uses_regex:
            self._patterns = [_compile(topic) for topic in self.topics]
        if self.exclude:
            self._exclude = _compile(self.exclude)

    @property
    def needs_polling(self) -> bool:
        """Whether the master must be polled for new topics."""
        return self.all_topics or self.uses_regex or bool(self.node)

    def fixed_topics(self) -> list[str]:
        """Return the topics to record even if they have no publisher."""
        return [] if self.uses_regex else list(self.topics)

    def selects(self, topic: str, node_topics: Collection[str] = ()) -> bool:
        """Return whether to record a discovered topic.

        Args:
            topic: its name.
            node_topics: the topics that `node` subscribes to.
        """
        if self._exclude is not None and self._exclude.fullmatch(topic):
            return False
        if self.all_topics or topic in node_topics:
            return True
        return any(pattern.fullmatch(topic) for pattern in self._patterns)


def _compile(expression: str) -> re.Pattern[str]:
    try:
        return re.compile(expression)
    except re.error as error:
        raise Error(f"{expression!r} is not a regular expression: {error}") from None
