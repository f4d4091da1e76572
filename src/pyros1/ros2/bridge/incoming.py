"""Converts messages from ROS 2, and publishes them in ROS 1."""

from __future__ import annotations

from collections.abc import Callable

from pyros1.bridge.bridge_publishers import BridgePublishers
from pyros1.bridge.clock import steady_now
from pyros1.bridge.deferred import RETURN_DELAY
from pyros1.bridge.exchange.actions import Advertise, Forget, Publish
from pyros1.ground.errors import Error, MessageError
from pyros1.ground.terminal_text import one_line
from pyros1.ros2.bridge.counts import Counts
from pyros1.ros2.bridge.plan import Plan, TakenTopic
from pyros1.ros2.bridge.services import SITE
from pyros1.ros2.bridge.sources import Ros2Publishers, Tokens
from pyros1.ros2.zenoh.attachments import decode_attachment
from pyros1.ros2.zenoh.names import DataKey


class IncomingMessages:
    """The publishers of a bridge. `take` and `forget_gone` are for one thread, `adjust` for another one.

    Args:
        publishing: publishes in ROS 1.
        counts: counts the messages.
        warn: logs a warning, given its text and an error, for which ``%s`` stands in the text.
    """

    def __init__(self, publishing: BridgePublishers, counts: Counts, warn: Callable[[str, Exception], object]) -> None:
        self._bridge_publishers = publishing
        self._counts = counts
        self._warn = warn
        self._advertised: dict[str, tuple[str, str]] = {}  # topic -> type and md5 sum
        self._latched: set[str] = set()  # those of them that were advertised as latched
        self._withdrawn_at: dict[str, float] = {}
        self._sources = Ros2Publishers()

    def take(self, plan: Plan, key: DataKey, body: bytes, attachment: bytes, session: str = "") -> None:
        """Publish a message.

        Args:
            plan: the current plan.
            key, body, attachment: the received message.
            session: the id of the publisher's session in zenoh; empty if it is not known.

        Raises:
            Error: the message cannot be published.
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
        source, gone = self._sources.get(key.name, origin.gid if taken.latched else b"", session, steady_now())
        if gone is not None:
            self._bridge_publishers.forget(Forget(*gone))
        if self._bridge_publishers.publish(Publish(key.name, source, converted, taken.latched)):
            flow.count(len(converted))
        else:
            flow.drop("came before its topic was advertised")

    def forget_gone(self, tokens_of: Callable[[str], Tokens], has_changed: bool) -> None:
        """Discard the latched messages of publishers that are gone, as in ROS 1.

        Args:
            tokens_of: returns a topic's current publishers, by their tokens.
            has_changed: whether a publisher came or went since the last call.
        """
        if not has_changed and not self._sources.must_check:
            return
        for gone in self._sources.pop_gone(tokens_of, steady_now()):
            self._bridge_publishers.forget(Forget(*gone))

    def adjust(self, plan: Plan, problems: dict[str, str]) -> None:
        """Advertise exactly the planned topics; add failures to `problems`. A withdrawn topic is advertised again only
        after `RETURN_DELAY`.
        """
        now = steady_now()
        self._withdrawn_at = {topic: at for topic, at in self._withdrawn_at.items() if now - at < RETURN_DELAY}
        for topic, type_ in [*self._advertised.items()]:
            taken = plan.takes.get(topic)
            if taken is None or (taken.pair.ros1, taken.pair.md5sum) != type_:
                self._bridge_publishers.withdraw(topic)
                del self._advertised[topic]
                self._latched.discard(topic)
                self._withdrawn_at[topic] = now
        for topic, taken in plan.takes.items():
            # A topic that is no longer latched in ROS 2 stays latched here, as with a ROS 1 node.
            is_new = topic not in self._advertised or (taken.latched and topic not in self._latched)
            if is_new and topic not in self._withdrawn_at:
                try:
                    self._advertise(topic, taken)
                except Error as error:
                    problems[topic] = one_line(error)

    def _advertise(self, topic: str, taken: TakenTopic) -> None:
        pair = taken.pair
        origins = tuple(f"{SITE}:{name}" for name in taken.publishers)
        self._bridge_publishers.advertise(
            Advertise(topic, pair.ros1, pair.md5sum, pair.definition, taken.latched, origins)
        )
        self._advertised[topic] = (pair.ros1, pair.md5sum)
        if taken.latched:
            self._latched.add(topic)
