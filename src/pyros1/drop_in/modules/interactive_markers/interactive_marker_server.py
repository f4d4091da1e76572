"""InteractiveMarkerServer: markers in RViz that the user can move, with callbacks."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from copy import deepcopy
from threading import Lock
from typing import Any

import rospy

from pyros1.msgs.std_msgs.msg import Header
from pyros1.msgs.visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerFeedback,
    InteractiveMarkerInit,
    InteractiveMarkerPose,
    InteractiveMarkerUpdate,
)

_KEEP_ALIVE = 0.5
"""Seconds between messages that say that the server is there."""
_OWNED = 1.0
"""Seconds for which a marker belongs to the RViz that has moved it last."""
_NO_HEADER = Header()


class MarkerContext:
    """A marker that clients know."""

    def __init__(self) -> None:
        self.last_feedback = rospy.Time.now()
        self.last_client_id = ""
        self.default_feedback_cb: Callable[[Any], object] | None = None
        self.feedback_cbs: dict[int, Callable[[Any], object]] = {}
        self.int_marker = InteractiveMarker()


class UpdateContext:
    """A change that clients do not know yet."""

    FULL_UPDATE = 0
    POSE_UPDATE = 1
    ERASE = 2

    def __init__(self) -> None:
        self.update_type = self.FULL_UPDATE
        self.int_marker = InteractiveMarker()
        self.default_feedback_cb: Callable[[Any], object] | None = None
        self.feedback_cbs: dict[int, Callable[[Any], object]] = {}


class InteractiveMarkerServer:
    """Server of markers that the user can move, on the topics update, update_full and feedback below a name.

    Changes are kept until `applyChanges`. Safe for several threads; callbacks run in those of the subscriber.

    Args:
        topic_ns: the name.
        server_id: appended to the node's name, for several servers of one node.
        q_size: length of the queues.
    """

    DEFAULT_FEEDBACK_CB = 255

    def __init__(self, topic_ns: str, server_id: str = "", q_size: int = 100) -> None:
        self.topic_ns = topic_ns
        self.seq_num = 0
        self.mutex = Lock()
        self.server_id = rospy.get_name() + server_id
        self.marker_contexts: dict[str, MarkerContext] = {}
        self.pending_updates: dict[str, UpdateContext] = {}
        self.init_pub = rospy.Publisher(f"{topic_ns}/update_full", InteractiveMarkerInit, queue_size=q_size, latch=True)
        self.update_pub = rospy.Publisher(f"{topic_ns}/update", InteractiveMarkerUpdate, queue_size=q_size)
        rospy.Subscriber(f"{topic_ns}/feedback", InteractiveMarkerFeedback, self.processFeedback, queue_size=q_size)
        rospy.Timer(rospy.Duration(_KEEP_ALIVE), self.keepAlive)
        self.publishInit()

    def __del__(self) -> None:
        """Remove the markers from the clients, if the node can still say so."""
        with suppress(Exception):
            self.clear()
            self.applyChanges()

    def insert(self, marker: Any, feedback_cb: Any = -1, feedback_type: int = DEFAULT_FEEDBACK_CB) -> None:
        """Add a visualization_msgs/InteractiveMarker, or replace that of the same name.

        Args:
            feedback_cb: called with each feedback; -1: unchanged.
            feedback_type: the event_type for which it is called; by default all that have no other callback.
        """
        with self.mutex:
            update = self.pending_updates.get(marker.name)
            if update is None:
                update = self.pending_updates[marker.name] = UpdateContext()
            update.update_type = UpdateContext.FULL_UPDATE
            update.int_marker = marker
        if feedback_cb != -1:
            self.setCallback(marker.name, feedback_cb, feedback_type)

    def setPose(self, name: str, pose: Any, header: Any = _NO_HEADER) -> bool:
        """Move a marker that clients know.

        Args:
            name: its name.
            pose: a geometry_msgs/Pose.
            header: frame and time of the pose; without a frame: as before.

        Returns:
            Whether there is such a marker, and no change by `insert` that is not applied yet.
        """
        with self.mutex:
            context, update = self.marker_contexts.get(name), self.pending_updates.get(name)
            if context is None or (update is not None and update.update_type == UpdateContext.FULL_UPDATE):
                return False
            self.doSetPose(update, name, pose, header if header.frame_id else context.int_marker.header)
            return True

    def erase(self, name: str) -> bool:
        """Remove a marker; return whether there is one."""
        with self.mutex:
            if name in self.marker_contexts:
                self._erase(name)
                return True
            return self.pending_updates.pop(name, None) is not None

    def _erase(self, name: str) -> None:
        update = self.pending_updates[name] = UpdateContext()
        update.update_type = UpdateContext.ERASE

    def clear(self) -> None:
        """Remove all markers."""
        with self.mutex:
            self.pending_updates = {}
            for name in self.marker_contexts:
                self._erase(name)

    def setCallback(self, name: str, feedback_cb: Any, feedback_type: int = DEFAULT_FEEDBACK_CB) -> bool:
        """Set or, with None, remove the callback of a marker; see `insert`. Return whether there is such a marker."""
        with self.mutex:
            contexts = [each for each in (self.marker_contexts.get(name), self.pending_updates.get(name)) if each]
            for context in contexts:
                if feedback_type == self.DEFAULT_FEEDBACK_CB:
                    context.default_feedback_cb = feedback_cb
                elif feedback_cb is None:
                    context.feedback_cbs.pop(feedback_type, None)
                else:
                    context.feedback_cbs[feedback_type] = feedback_cb
            return bool(contexts)

    def applyChanges(self) -> None:
        """Send all changes to the clients."""
        with self.mutex:
            if not self.pending_updates:
                return
            message = InteractiveMarkerUpdate(type=InteractiveMarkerUpdate.UPDATE)
            for name, update in self.pending_updates.items():
                self._apply(name, update, message)
            self.pending_updates = {}
            self.seq_num += 1
            self.publish(message)
        self.publishInit()

    def _apply(self, name: str, update: UpdateContext, message: Any) -> None:
        if update.update_type == UpdateContext.ERASE:
            self.marker_contexts.pop(name, None)
            message.erases.append(name)
            return
        context = self.marker_contexts.get(name)
        if update.update_type == UpdateContext.FULL_UPDATE:
            if context is None:
                context = self.marker_contexts[name] = MarkerContext()
                context.default_feedback_cb = update.default_feedback_cb
                context.feedback_cbs = update.feedback_cbs
            context.int_marker = update.int_marker
            message.markers.append(context.int_marker)
        elif context is None:
            rospy.logerr("Pending pose update for non-existing marker found. This is a bug in InteractiveMarkerServer.")
        else:
            marker = context.int_marker
            marker.pose, marker.header = update.int_marker.pose, update.int_marker.header
            message.poses.append(InteractiveMarkerPose(header=marker.header, pose=marker.pose, name=marker.name))

    def get(self, name: str) -> Any:
        """Return a copy of a marker, with the changes that are not applied yet; None if there is none."""
        with self.mutex:
            context, update = self.marker_contexts.get(name), self.pending_updates.get(name)
            if update is None:
                return None if context is None else deepcopy(context.int_marker)
            if update.update_type == UpdateContext.ERASE:
                return None
            if update.update_type == UpdateContext.FULL_UPDATE:
                return deepcopy(update.int_marker)
            if context is None:
                return None
            marker = deepcopy(context.int_marker)
            marker.pose = deepcopy(update.int_marker.pose)
            return marker

    def processFeedback(self, feedback: Any) -> None:
        """Take a message of a client: move the marker, and call its callback."""
        with self.mutex:
            context = self.marker_contexts.get(feedback.marker_name)
            if context is None:
                return
            now = rospy.Time.now()
            if context.last_client_id != feedback.client_id and (now - context.last_feedback).to_sec() < _OWNED:
                return  # two users pull at it
            context.last_feedback, context.last_client_id = now, feedback.client_id
            if feedback.event_type == feedback.POSE_UPDATE:
                # a marker without a stamp stays in its frame as that moves
                header = context.int_marker.header
                if header.stamp != rospy.Time():
                    header = feedback.header
                update = self.pending_updates.get(feedback.marker_name)
                self.doSetPose(update, feedback.marker_name, feedback.pose, header)
            callback = context.feedback_cbs.get(feedback.event_type) or context.default_feedback_cb
        if callback is not None:
            callback(feedback)

    def keepAlive(self, msg: Any) -> None:
        """Tell the clients that the server is there."""
        self.publish(InteractiveMarkerUpdate(type=InteractiveMarkerUpdate.KEEP_ALIVE))

    def publish(self, update: Any) -> None:
        """Publish an update, with the server's name and number."""
        update.server_id = self.server_id
        update.seq_num = self.seq_num
        self.update_pub.publish(update)

    def publishInit(self) -> None:
        """Publish all markers, for clients that come later."""
        with self.mutex:
            markers = [context.int_marker for context in self.marker_contexts.values()]
            message = InteractiveMarkerInit(server_id=self.server_id, seq_num=self.seq_num, markers=markers)
            self.init_pub.publish(message)

    def doSetPose(self, update: Any, name: str, pose: Any, header: Any) -> None:
        """Note a new pose; the lock must be held.

        Args:
            update: the UpdateContext that waits for `applyChanges`; None for a new one.
            name: of the marker.
            pose: a geometry_msgs/Pose.
            header: a std_msgs/Header.
        """
        if update is None or update.update_type == UpdateContext.ERASE:
            update = self.pending_updates[name] = UpdateContext()
            update.update_type = UpdateContext.POSE_UPDATE
        update.int_marker.pose, update.int_marker.header = pose, header
