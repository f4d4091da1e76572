"""The topics that a bridge publishes on its site's master. No I/O.

Several topics of other sites may have the same local name; they must then have the same type, which the first one
decides.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from pyros1.bridge.exchange.actions import Action, Advertise, Forget, SetOrigins, Source, Withdraw
from pyros1.bridge.names import SharedName

Feed = tuple[str, SharedName]
"""A topic and the site that sends it."""


class Output(NamedTuple):
    """A topic that is published here.

    Attributes:
        type, md5sum, definition: its message type.
        latched: whether it has latched messages.
    """

    type: str
    md5sum: str
    definition: str
    latched: bool


class Outputs:
    """The topics that are published here, by name."""

    def __init__(self) -> None:
        self._outputs: dict[str, Output] = {}
        self._origins: dict[str, tuple[str, ...]] = {}
        self._sources: dict[str, set[Source]] = {}  # topic -> its sources with latched messages

    def changed(self, wanted: Mapping[str, Output]) -> set[str]:
        """Return the topics that `update` would withdraw, even if it publishes them again with another type."""
        return {
            local
            for local, output in self._outputs.items()
            if local not in wanted or wanted[local]._replace(latched=output.latched) != output
        }

    def update(self, wanted: Mapping[str, Output], origins: Mapping[str, tuple[str, ...]]) -> list[Action]:
        """Return the actions after which exactly these topics are published.

        Args:
            wanted: the topics, by name.
            origins: the original publishers of each.
        """
        actions: list[Action] = []
        for local in sorted(self.changed(wanted)):
            actions.append(Withdraw(local))
            del self._outputs[local]
            self._sources.pop(local, None)
        for local, output in wanted.items():
            if self._outputs.get(local) != output:
                self._outputs[local] = output
                actions.append(Advertise(local, *output, origins.get(local, ())))
            elif origins.get(local, ()) != self._origins.get(local, ()):
                actions.append(SetOrigins(local, origins.get(local, ())))
        self._origins = dict(origins)
        return actions

    def __contains__(self, local: str) -> bool:
        return local in self._outputs

    def is_latched(self, local: str) -> bool:
        """Return whether a topic that is published here has latched messages."""
        output = self._outputs.get(local)
        return output is not None and output.latched

    def hold(self, local: str, source: Source) -> None:
        """Record that the last message of a source is kept."""
        self._sources.setdefault(local, set()).add(source)

    def forget(self, local: str, source: Source) -> list[Action]:
        """Return the action that discards the last message of a source."""
        sources = self._sources.get(local, set())
        if source not in sources:
            return []
        sources.remove(source)
        return [Forget(local, source)]

    def forget_feed(self, local: str, feed: Feed) -> list[Action]:
        """Return the actions that discard all messages kept from another site's topic."""
        sources = [source for source in self._sources.get(local, ()) if source[:2] == feed]
        return [action for source in sorted(sources) for action in self.forget(local, source)]


class Candidate(NamedTuple):
    """A topic of another site that could be published here.

    Attributes:
        local: its name here.
        feed: where it comes from.
        output: its type; None until its definition is known.
    """

    local: str
    feed: Feed
    output: Output | None


def choose(candidates: Iterable[Candidate]) -> tuple[dict[str, Output], dict[Feed, str]]:
    """Return what to publish, by name, and why some topics cannot be published.

    Args:
        candidates: the topics of other sites; the first one with a name decides its type.
    """
    outputs: dict[str, Output] = {}
    refused: dict[Feed, str] = {}
    for local, feed, output in candidates:
        known = outputs.get(local)
        if output is None:
            continue
        if known is None:
            outputs[local] = output
        elif known.md5sum != output.md5sum:
            refused[feed] = f"{local} is already a {known.type}, not a {output.type}"
        elif output.latched and not known.latched:
            outputs[local] = known._replace(latched=True)
    return outputs, refused
