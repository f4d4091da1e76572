"""Server for markers that users move and click in RViz (https://wiki.ros.org/interactive_markers)."""

from __future__ import annotations

from collections.abc import Callable
from threading import Lock
from typing import Any

import rospy

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.std_msgs.msg import Header
from pyros1.msgs.visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerFeedback,
    InteractiveMarkerInit,
    InteractiveMarkerPose,
    InteractiveMarkerUpdate,
)

__getattr__ = module_getattr("interactive_markers.interactive_marker_server")

_KEEP_ALIVE_INTERVAL = 0.5
"""Seconds between keep-alive messages for clients."""
_EXCLUSIVE_TIME = 1.0
"""Seconds for which a marker belongs to the client that moved it last."""
_KEEP_CALLBACKS = -1
"""Passed instead of a callback to keep the current callbacks."""

FeedbackCallback = Callable[[Any], object]


class _MarkerWithCallbacks:
    """A marker and the callbacks for its feedback.

    Attributes:
        int_marker: the InteractiveMarker.
        default_feedback_cb: called with feedback for which no other callback is set.
        feedback_cbs: callbacks by the feedback's event type.
    """

    def __init__(self) -> None:
        self.int_marker = InteractiveMarker()
        self.default_feedback_cb: FeedbackCallback | None = None
        self.feedback_cbs: dict[int, FeedbackCallback] = {}


class MarkerContext(_MarkerWithCallbacks):
    """A marker that clients know.

    Attributes:
        last_feedback: rospy.Time of the last feedback.
        last_client_id: the client that sent the last feedback.
    """

    def __init__(self) -> None:
        super().__init__()
        self.last_feedback = rospy.Time.now()
        self.last_client_id = ""


class UpdateContext(_MarkerWithCallbacks):
    """A change that has not been sent to clients yet.

    Attributes:
        update_type: FULL_UPDATE (a new or replaced marker), POSE_UPDATE or ERASE.
    """

    FULL_UPDATE = 0
    POSE_UPDATE = 1
    ERASE = 2

    def __init__(self) -> None:
        super().__init__()
        self.update_type = self.FULL_UPDATE


class InteractiveMarkerServer:
    """Shows markers, and calls callbacks with the feedback of users.

    Changes are sent to clients by `applyChanges`. Callbacks may call all methods.

    Args:
        topic_ns: namespace of the topics update, update_full and feedback.
        server_id: suffix added to the node's name; needed if a node has several servers in one namespace.
        q_size: maximum number of queued feedback messages.
    """

    DEFAULT_FEEDBACK_CB = 255

    def __init__(self, topic_ns: str, server_id: str = "", q_size: int = 100) -> None:
        self.topic_ns = topic_ns
        self.seq_num = 0
        self.mutex = Lock()
        self.server_id = rospy.get_name() + server_id
        self.marker_contexts: dict[str, MarkerContext] = {}
        self.pending_updates: dict[str, UpdateContext] = {}
        self.init_pub = rospy.Publisher(f"{topic_ns}/update_full", InteractiveMarkerInit, latch=True, queue_size=100)
        self.update_pub = rospy.Publisher(f"{topic_ns}/update", InteractiveMarkerUpdate, queue_size=100)
        rospy.Subscriber(f"{topic_ns}/feedback", InteractiveMarkerFeedback, self.processFeedback, queue_size=q_size)
        rospy.Timer(rospy.Duration(_KEEP_ALIVE_INTERVAL), self.keepAlive, reset=True)
        self.publishInit()

    def __del__(self) -> None:
        if not hasattr(self, "update_pub"):
            return
        self.clear()
        self.applyChanges()

    def insert(self, marker: Any, feedback_cb: Any = _KEEP_CALLBACKS, feedback_type: int = DEFAULT_FEEDBACK_CB) -> None:
        """Add a marker, or replace it.

        Args:
            marker: the InteractiveMarker, identified by its name.
            feedback_cb, feedback_type: see `setCallback`; a ``feedback_cb`` of -1 keeps the current callbacks.
        """
        with self.mutex:
            update = self.pending_updates.setdefault(marker.name, UpdateContext())
            update.update_type = UpdateContext.FULL_UPDATE
            update.int_marker = marker
        if feedback_cb != _KEEP_CALLBACKS:
            self.setCallback(marker.name, feedback_cb, feedback_type)

    def setPose(self, name: str, pose: Any, header: Any = Header()) -> bool:  # noqa: B008  stock's signature
        """Move a marker.

        Args:
            name: name of the marker.
            pose: the new geometry_msgs/Pose.
            header: header of the pose; without a frame_id, the marker keeps its own.

        Returns:
            Whether the marker could be moved: it has been sent to clients, and is not about to be inserted again.
        """
        with self.mutex:
            context, update = self.marker_contexts.get(name), self.pending_updates.get(name)
            if context is None or (update is not None and update.update_type == UpdateContext.FULL_UPDATE):
                return False
            self.doSetPose(update, name, pose, header if header.frame_id else context.int_marker.header)
            return True

    def erase(self, name: str) -> bool:
        """Remove a marker; return whether it existed."""
        with self.mutex:
            return self._erase(name)

    def clear(self) -> None:
        """Remove all markers."""
        with self.mutex:
            self.pending_updates.clear()
            for name in self.marker_contexts:
                self._erase(name)

    def get(self, name: str) -> Any:
        """Return a marker with all changes, even those not yet sent to clients; None if there is no such marker."""
        with self.mutex:
            context, update = self.marker_contexts.get(name), self.pending_updates.get(name)
            if update is None:
                return context and context.int_marker
            if update.update_type == UpdateContext.ERASE:
                return None
            if update.update_type == UpdateContext.FULL_UPDATE:
                return update.int_marker
            if context is None:
                return None
            context.int_marker.pose = update.int_marker.pose
            return context.int_marker

    def setCallback(
        self, name: str, feedback_cb: FeedbackCallback | None, feedback_type: int = DEFAULT_FEEDBACK_CB
    ) -> bool:
        """Set the callback for feedback to a marker.

        Args:
            name: name of the marker.
            feedback_cb: called with an InteractiveMarkerFeedback; None to remove the callback.
            feedback_type: the event type of the feedback; DEFAULT_FEEDBACK_CB for all types without their own callback.

        Returns:
            Whether there is such a marker.
        """
        with self.mutex:
            contexts = [table[name] for table in (self.marker_contexts, self.pending_updates) if name in table]
            for context in contexts:
                if feedback_type == self.DEFAULT_FEEDBACK_CB:
                    context.default_feedback_cb = feedback_cb
                elif feedback_cb:
                    context.feedback_cbs[feedback_type] = feedback_cb
                else:
                    context.feedback_cbs.pop(feedback_type, None)
            return bool(contexts)

    def applyChanges(self) -> None:
        """Send all changes to the clients."""
        with self.mutex:
            if not self.pending_updates:
                return
            message = InteractiveMarkerUpdate(type=InteractiveMarkerUpdate.UPDATE)
            for name, update in self.pending_updates.items():
                self._apply(name, update, message)
            self.pending_updates.clear()
            self.seq_num += 1
            self.publish(message)
        self.publishInit()

    def _apply(self, name: str, update: UpdateContext, message: Any) -> None:
        context = self.marker_contexts.get(name)
        if update.update_type == UpdateContext.FULL_UPDATE:
            if context is None:
                rospy.logdebug("Creating new context for %s", name)
                context = self.marker_contexts[name] = MarkerContext()
                context.default_feedback_cb, context.feedback_cbs = update.default_feedback_cb, update.feedback_cbs
            context.int_marker = update.int_marker
            message.markers.append(update.int_marker)
        elif update.update_type == UpdateContext.ERASE:
            self.marker_contexts.pop(name, None)
            message.erases.append(name)
        elif context is not None:
            marker = context.int_marker
            marker.pose, marker.header = update.int_marker.pose, update.int_marker.header
            message.poses.append(InteractiveMarkerPose(header=marker.header, pose=marker.pose, name=marker.name))

    def _erase(self, name: str) -> bool:
        if name not in self.marker_contexts and name not in self.pending_updates:
            return False
        self.pending_updates.setdefault(name, UpdateContext()).update_type = UpdateContext.ERASE
        return True

    def doSetPose(self, update: Any, name: str, pose: Any, header: Any) -> None:
        """Record a new pose; the caller holds the mutex.

        Args:
            update: the `UpdateContext` with the changes not yet sent to clients; None if there are none.
            name, pose, header: the marker's name and new pose.
        """
        if update is None:
            update = self.pending_updates[name] = UpdateContext()
            update.update_type = UpdateContext.POSE_UPDATE
        elif update.update_type != UpdateContext.FULL_UPDATE:
            update.update_type = UpdateContext.POSE_UPDATE
        update.int_marker.pose, update.int_marker.header = pose, header
        position = pose.position
        rospy.logdebug("Marker '%s' is now at %s, %s, %s", name, position.x, position.y, position.z)

    # Topics -----------------------------------------------------------------------------------------------------------

    def processFeedback(self, feedback: Any) -> None:
        """Handle a message on the feedback topic: move the marker, and call its callback."""
        with self.mutex:
            name = feedback.marker_name
            context = self.marker_contexts.get(name)
            if context is None:
                return
            now = rospy.Time.now()
            if (
                context.last_client_id != feedback.client_id
                and (now - context.last_feedback).to_sec() < _EXCLUSIVE_TIME
            ):
                rospy.logdebug("Rejecting feedback for %s: conflicting feedback from separate clients.", name)
                return
            context.last_feedback, context.last_client_id = now, feedback.client_id
            if feedback.event_type == InteractiveMarkerFeedback.POSE_UPDATE:
                # Without a stamp, the marker moves with its frame.
                is_fixed = context.int_marker.header.stamp.is_zero()
                header = context.int_marker.header if is_fixed else feedback.header
                self.doSetPose(self.pending_updates.get(name), name, feedback.pose, header)
            callback = context.feedback_cbs.get(feedback.event_type, context.default_feedback_cb)
        if callback:
            callback(feedback)

    def keepAlive(self, msg: Any) -> None:
        """Tell clients that the server is alive; this is the timer's callback."""
        self.publish(InteractiveMarkerUpdate(type=InteractiveMarkerUpdate.KEEP_ALIVE))

    def publish(self, update: Any) -> None:
        """Publish an InteractiveMarkerUpdate, after adding the server's id and sequence number to it."""
        update.server_id, update.seq_num = self.server_id, self.seq_num
        self.update_pub.publish(update)

    def publishInit(self) -> None:
        """Publish all markers, for clients that connect later."""
        with self.mutex:
            message = InteractiveMarkerInit(server_id=self.server_id, seq_num=self.seq_num)
            for name, context in self.marker_contexts.items():
                rospy.logdebug("Publishing %s", name)
                message.markers.append(context.int_marker)
            self.init_pub.publish(message)
