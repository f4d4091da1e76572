"""Publishes statistics of topics on /statistics, if /enable_statistics is true when a topic is subscribed
(https://wiki.ros.org/Topics#Topic_statistics).
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

from pyros1.drop_in.module_attributes import module_hooks as _module_hooks
from pyros1.drop_in.process import PROCESS
from pyros1.msgs import AnyMsg
from pyros1.node.subscribing.statistics import Limits, Report, Window
from rospy.rostime import Duration, Time, get_time

if TYPE_CHECKING:
    from rospy.impl.topic_impls import SubscriberImpl

_HEADER = struct.Struct("<III")
_MAX_PUBLISHERS = 1000
_LIMITS = ("min_elements", "max_elements", "min_size", "max_size")


class SubscriberStatisticsLogger:
    """Publishes the statistics of a topic to which this program subscribes.

    Args:
        subscriber: the `SubscriberImpl` of the topic.
    """

    def __init__(self, subscriber: SubscriberImpl) -> None:
        from rospy.client import get_param
        from rospy.topics import Publisher

        self.subscriber_name = subscriber.name
        self._has_header: bool = subscriber.data_class._has_header
        values = (
            get_param(f"/statistics_window_{name}", default) for name, default in zip(_LIMITS, Limits(), strict=True)
        )
        self._limits = Limits(*values)
        self._windows: dict[str, Window] = {}
        node: Any = PROCESS.node
        self._publisher = Publisher("/statistics", _message_class(), queue_size=10)
        self._handle = node.subscribe(subscriber.name, AnyMsg, self._on_message)

    @classmethod
    def is_enabled(cls) -> bool:
        """Return the parameter /enable_statistics."""
        from rospy.client import get_param

        return bool(get_param("/enable_statistics", False))

    def _on_message(self, message: AnyMsg) -> None:
        sender = (message._connection_header or {}).get("callerid", "")
        if sender not in self._windows:
            if len(self._windows) >= _MAX_PUBLISHERS:
                self._windows.clear()
            self._windows[sender] = Window(get_time(), self._limits)
        body: Any = message._buff
        seq = stamp = None
        if self._has_header and len(body) >= _HEADER.size:
            seq, secs, nsecs = _HEADER.unpack_from(body)
            stamp = secs + nsecs / 1e9
        report = self._windows[sender].add(get_time(), len(body) + 4, seq, stamp)
        if report is not None:
            self._publish(sender, report)

    def _publish(self, sender: str, report: Report) -> None:
        node: Any = PROCESS.node
        message: Any = _message_class()(
            topic=self.subscriber_name,
            node_pub=sender,
            node_sub=node.name,
            window_start=Time(report.start),
            window_stop=Time(report.stop),
            delivered_msgs=report.messages,
            dropped_msgs=report.lost,
            traffic=report.size,
        )
        for name, values in (("period", report.period), ("stamp_age", report.age)):
            for suffix, value in zip(("mean", "stddev", "max"), values, strict=True):
                setattr(message, f"{name}_{suffix}", Duration(value))
        self._publisher.publish(message)

    def shutdown(self) -> None:
        """End the statistics of the topic."""
        self._handle.unregister()
        self._publisher.unregister()


def _message_class() -> Any:
    from pyros1.msgs.rosgraph_msgs.msg import TopicStatistics

    return TopicStatistics


__getattr__, __dir__ = _module_hooks(
    __name__, missing_reasons={"ConnectionStatisticsLogger": "see SubscriberStatisticsLogger"}
)
