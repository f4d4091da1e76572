"""LazyTransport, a base class for nodes that subscribe only while somebody listens (https://wiki.ros.org/topic_tools)."""

from __future__ import annotations

from typing import Any

import rospy

_WARNING_DELAY = 5.0
"""Seconds after which a node that has never subscribed logs a warning."""


class LazyTransport(rospy.SubscribeListener):
    """Subscribes when its publishers have subscribers, and unsubscribes when they no longer have any.

    If the parameter ``~lazy`` is false, it never unsubscribes. Programs define `subscribe` and `unsubscribe`, and use
    the publishers returned by `advertise`.
    """

    def __init__(self) -> None:
        self._publishers: list[rospy.Publisher] = []
        self._connection_status: bool | None = None  # None until the first subscriber connects
        rospy.Timer(rospy.Duration.from_sec(_WARNING_DELAY), self._warn_never_subscribed_cb, oneshot=True)

    def _warn_never_subscribed_cb(self, timer_event: Any) -> None:
        if self._connection_status is None:
            rospy.logwarn(
                "[%s] subscribes topics only with child subscribers. Set '~lazy' as False to have it always transport "
                "message.",
                rospy.get_name(),
            )

    def subscribe(self) -> None:
        """Subscribe to the input."""
        raise NotImplementedError("Please overwrite this method")

    def unsubscribe(self) -> None:
        """Unsubscribe from the input."""
        raise NotImplementedError("Please overwrite this method")

    def peer_subscribe(self, *args: Any, **kwargs: Any) -> None:
        """Handle a new subscriber of a publisher."""
        if not self._connection_status:
            self._connection_status = True
            self.subscribe()

    def peer_unsubscribe(self, *args: Any, **kwargs: Any) -> None:
        """Handle the disconnection of a subscriber."""
        if not rospy.get_param("~lazy", True):
            return
        if self._connection_status and not any(publisher.get_num_connections() for publisher in self._publishers):
            self._connection_status = False
            self.unsubscribe()

    def advertise(self, *args: Any, **kwargs: Any) -> rospy.Publisher:
        """Create a `rospy.Publisher` with the same arguments, whose subscribers are monitored.

        Raises:
            AssertionError: a ``subscriber_listener`` was passed.
        """
        if len(args) > 2 or kwargs.get("subscriber_listener") is not None:
            raise AssertionError("a LazyTransport is the subscriber_listener itself")
        publisher = rospy.Publisher(*args, **{**kwargs, "subscriber_listener": self})
        self._publishers.append(publisher)
        return publisher
