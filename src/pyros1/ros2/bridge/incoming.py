"""What a bridge takes from ROS 2: converts the messages, and publishes them in ROS 1."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count

from pyros1.bridge.exchange.actions import Advertise, Forget, Publish, Source
from pyros1.bridge.names import SharedName
from pyros1.bridge.publishing import Publishing
from pyros1.ground.errors import Error, MessageError
from pyros1.ground.terminal_text import one_line
from pyros1.ros2.bridge.counts import Counts
from pyros1.ros2.bridge.plan import Plan
from pyros1.ros2.bridge.services import SITE
from pyros1.ros2.zenoh.attachments import decode_attachment
from pyros1.ros2.zenoh.names import DataKey

MAX_SOURCES = 1000
"""Maximum number of latched publishers of ROS 2 that are told apart, and topics that are not latched."""


class Incoming:
    """The publishers of a bridge. `take` is for one thread, `adjust` for another one.

    Args:
        publishing: publishes in ROS 1.
        counts: counts the messages.
        warn: logs a text with an error.
    """

    def __init__(self, publishing: Publishing, counts: Counts, warn: Callable[[str, Exception], object]) -> None:
        self._publishing = publishing
        self._counts = counts
        self._warn = warn
        self._advertised: dict[str, tuple[str, str, bool]] = {}  # topic -> type, md5 sum, whether it is latched
        self._sources: dict[tuple[str, bytes], Source] = {}
        self._source_numbers = count(1)

    def take(self, plan: Plan, key: DataKey, body: bytes, attachment: bytes) -> None:
        """Publish a message.

        Args:
            plan: what the bridge does now.
            key, body, attachment: what came.

        Raises:
            Error: it cannot be published.
        """
        origin, flow = decode_attachment(attachment), self._counts.to_ros1(key.name)
        taken = plan.takes.get(key.name)
        entry = None if taken is None else taken.keys.get(key)
        if taken is None or entry is None or origin is None:
            flow.drop("its publisher is not known")
            return
        try:
            converted = entry[0].transcoder.from_cdr(body, flow.messages + 1)
        except MessageError as error:
            flow.drop("could not be converted")
            self._warn(f"cannot convert a message on {one_line(key.name)}: %s", error)
            return
        # Only the last message of each latched publisher is kept.
        source = self._source(key.name, origin.gid if taken.latched else b"")
        if self._publishing.publish(Publish(key.name, source, converted, taken.latched)):
            flow.count(len(converted))
        else:
            flow.drop("came before its topic was advertised")

    def _source(self, topic: str, gid: bytes) -> Source:
        """Return what stands for a publisher; that of which nothing has come for the longest time is forgotten if there
        are too many.
        """
        source = self._sources.pop((topic, gid), None)
        if source is None:
            source = Source(SITE, SharedName(SITE, topic), next(self._source_numbers))
            if len(self._sources) >= MAX_SOURCES:
                oldest = next(iter(self._sources))
                self._publishing.forget(Forget(oldest[0], self._sources.pop(oldest)))
        self._sources[topic, gid] = source
        return source

    def adjust(self, plan: Plan, problems: dict[str, str]) -> None:
        """Advertise what the plan says, and nothing else; add what cannot be done to `problems`."""
        for topic, type_ in [*self._advertised.items()]:
            taken = plan.takes.get(topic)
            if taken is None or (taken.pair.ros1, taken.pair.md5sum, taken.latched) != type_:
                self._publishing.withdraw(topic)
                del self._advertised[topic]
        for topic, taken in plan.takes.items():
            if topic not in self._advertised:
                pair = taken.pair
                origins = tuple(f"{SITE}:{name}" for name in taken.publishers)
                try:
                    self._publishing.advertise(
                        Advertise(topic, pair.ros1, pair.md5sum, pair.definition, taken.latched, origins)
                    )
                    self._advertised[topic] = (pair.ros1, pair.md5sum, taken.latched)
                except Error as error:
                    problems[topic] = one_line(error)
