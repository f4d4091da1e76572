"""The goals that clients in ROS 2 send to an action server in ROS 1. No I/O, no clock.

ROS 2 clients send requests and wait for responses; ROS 1 servers publish the status of their goals. So a request waits
here until the server has published enough to answer it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from hashlib import sha256
from typing import NamedTuple

from pyros1.actions.states import Status
from pyros1.ros2.bridge.actions.ros1_messages import NO_STAMP, GoalStatus, Stamp
from pyros1.ros2.bridge.actions.ros2_messages import (
    NO_UUID,
    UUID_SIZE,
    CancelCode,
    GoalInfo,
    ReportedGoal,
    Ros2Status,
)

ACCEPT_TIME = 5.0
"""Seconds within which the server must report a goal; otherwise it is cancelled, and counts as not accepted."""
PENDING_TIME = 1.0
"""Seconds after which a goal that the server reports as pending counts as accepted."""
RESULT_TIME = 5.0
"""Seconds to wait for a result after the status of its goal has become final."""
REPORT_TIME = 5.0
"""Seconds for which an ended goal is still reported."""
KEEP_TIME = 900.0
"""Seconds for which a result is kept."""
MAX_GOALS = 256
"""Maximum number of active goals; more are not accepted."""
MAX_RESULTS = 256
MAX_RESULT_BYTES = 64 << 20
"""Maximum total size in bytes of the results that are kept; the newest is kept in any case."""
MAX_WAITING = 8
"""Maximum number of requests that wait for the result of one goal."""
MAX_OTHERS = 100
"""Maximum number of ROS 1 clients' goals that are reported to ROS 2."""

_ROS2_STATUSES = {
    Status.PENDING: Ros2Status.ACCEPTED,
    Status.ACTIVE: Ros2Status.EXECUTING,
    Status.PREEMPTED: Ros2Status.CANCELED,
    Status.SUCCEEDED: Ros2Status.SUCCEEDED,
    Status.ABORTED: Ros2Status.ABORTED,
    Status.REJECTED: Ros2Status.ABORTED,
    Status.PREEMPTING: Ros2Status.CANCELING,
    Status.RECALLING: Ros2Status.CANCELING,
    Status.RECALLED: Ros2Status.CANCELED,
    Status.LOST: Ros2Status.ABORTED,
}
_REFUSED = (Status.REJECTED, Status.RECALLED)


class SendGoal(NamedTuple):
    """Publish a goal in ROS 1."""

    name: str
    goal: bytes


class SendCancel(NamedTuple):
    """Publish a cancel request in ROS 1."""

    name: str
    stamp: Stamp


class AnswerGoal(NamedTuple):
    """Tell a client whether its goal is accepted."""

    call: object
    accepted: bool
    stamp: Stamp


class AnswerResult(NamedTuple):
    """Tell a client how a goal has ended; if the result is None, the client gets an empty one."""

    call: object
    status: Ros2Status
    result: bytes | None


class AnswerCancel(NamedTuple):
    """Tell a client which goals are being cancelled."""

    call: object
    code: CancelCode
    goals: tuple[GoalInfo, ...]


class EndWithoutResponse(NamedTuple):
    """End a call without a response."""

    call: object
    text: str


class SendFeedback(NamedTuple):
    """Publish feedback in ROS 2."""

    uuid: bytes
    feedback: bytes


class SendStatuses(NamedTuple):
    """Publish the status of all goals in ROS 2."""

    goals: tuple[ReportedGoal, ...]


Step = (
    SendGoal | SendCancel | AnswerGoal | AnswerResult | AnswerCancel | EndWithoutResponse | SendFeedback | SendStatuses
)


@dataclass
class _Goal:
    name: str
    uuid: bytes
    sent_at: float
    call: object | None  # the client's request, until we know whether the goal is accepted
    accepted: bool = False
    is_reported: bool = False
    status: Status = Status.PENDING
    stamp: Stamp = NO_STAMP
    pending_since: float | None = None
    final_since: float | None = None
    end: Ros2Status | None = None
    ended_at: float = 0.0
    result: bytes | None = None
    waiting: list[object] = field(default_factory=list)

    @property
    def is_active(self) -> bool:
        return self.end is None

    @property
    def can_be_cancelled(self) -> bool:
        return self.accepted and self.end is None and self.final_since is None

    def to_status(self) -> ReportedGoal:
        return ReportedGoal(GoalInfo(self.uuid, self.stamp), self.end or _ROS2_STATUSES[self.status])


class GoalsToRos1:
    """The state of the goals of one action server. Each method returns the actions to perform, in order.

    A goal's name in ROS 1 is its UUID in hexadecimal digits. Goals from ROS 1 clients are reported to ROS 2, too,
    so that they can be cancelled there: their UUIDs are made from their names.

    Times are in seconds, from any clock that does not go back.
    """

    def __init__(self) -> None:
        self._goals: dict[bytes, _Goal] = {}  # ended goals, in the order in which they ended
        self._others: dict[bytes, GoalStatus] = {}
        self._last_statuses: tuple[ReportedGoal, ...] = ()
        self._is_lost = False
        self._steps: list[Step] = []

    # Requests from ROS 2 clients --------------------------------------------------------------------------------------

    def on_goal(self, call: object, uuid: bytes, goal: bytes, now: float) -> list[Step]:
        """Handle a new goal; the call is answered when the server has accepted the goal."""
        num_active = sum(each.is_active for each in self._goals.values())
        is_new = len(uuid) == UUID_SIZE and uuid != NO_UUID and uuid not in self._goals
        if self._is_lost or not is_new or num_active >= MAX_GOALS:
            return [AnswerGoal(call, False, NO_STAMP)]
        name = uuid.hex()
        self._goals[uuid] = _Goal(name, uuid, now, call)
        return [SendGoal(name, goal)]

    def on_result_request(self, call: object, uuid: bytes) -> list[Step]:
        """Handle a request for the result of a goal, which is answered when the goal has ended."""
        goal = self._goals.get(uuid)
        if goal is None:
            return [AnswerResult(call, Ros2Status.UNKNOWN, None)]
        if goal.end is not None:
            return [AnswerResult(call, goal.end, goal.result)]
        if len(goal.waiting) >= MAX_WAITING:
            return [EndWithoutResponse(call, "too many requests wait for the result of this goal")]
        goal.waiting.append(call)
        return []

    def on_cancel(self, call: object, info: GoalInfo) -> list[Step]:
        """Handle a cancel request, which is for one goal, for all goals up to a time, for both, or, if it names
        neither, for all goals.
        """
        active = {each.uuid: GoalInfo(each.uuid, each.stamp) for each in self._goals.values() if each.can_be_cancelled}
        active |= {
            uuid: GoalInfo(uuid, each.stamp) for uuid, each in self._others.items() if not Status(each.status).ended
        }
        uuid, stamp = info
        if uuid != NO_UUID and uuid not in active and stamp == NO_STAMP:
            code = CancelCode.ENDED if uuid in self._goals or uuid in self._others else CancelCode.UNKNOWN_GOAL
            return [AnswerCancel(call, code, ())]
        if uuid == NO_UUID and stamp == NO_STAMP:
            chosen = [*active.values()]
        else:
            chosen = [each for each in active.values() if each.uuid == uuid or NO_STAMP != each.stamp <= stamp]
        other = self._others.get(uuid)
        name = "" if uuid == NO_UUID else uuid.hex() if other is None else other.name
        return [SendCancel(name, stamp), AnswerCancel(call, CancelCode.NONE, tuple(chosen))]

    # Messages from the ROS 1 side -------------------------------------------------------------------------------------

    def on_statuses(self, statuses: Iterable[GoalStatus], now: float) -> list[Step]:
        """Record the status of all goals that the server knows."""
        reported = {_uuid(each.name): each for each in statuses if each.status in _ROS2_STATUSES}
        for goal in [*self._goals.values()]:
            status = reported.get(goal.uuid)
            if status is not None:
                goal.is_reported = True
                self._apply(goal, status, now)
            elif goal.is_reported and goal.is_active and goal.final_since is None:
                self._end(goal, Ros2Status.ABORTED, None, now)  # a restarted server does not know it
        # Refused goals were never accepted, so they do not count as goals in ROS 2.
        others = {
            uuid: each for uuid, each in reported.items() if uuid not in self._goals and each.status not in _REFUSED
        }
        self._others = dict([*others.items()][-MAX_OTHERS:])
        return self._take_steps(now)

    def on_feedback(self, status: GoalStatus, feedback: bytes, now: float) -> list[Step]:
        """Pass on feedback from the server to ROS 2."""
        uuid = _uuid(status.name)
        goal = self._goals.get(uuid)
        if goal is not None:
            if not goal.is_active:
                return []
            self._apply(goal, status, now)
        self._steps.append(SendFeedback(uuid, feedback))
        return self._take_steps(now)

    def on_result(self, status: GoalStatus, result: bytes, now: float) -> list[Step]:
        """Handle the result of a goal, which means that it has ended."""
        goal = self._goals.get(_uuid(status.name))
        if goal is not None and goal.is_active:
            self._apply(goal, status, now)
            if goal.uuid in self._goals:
                end = _ROS2_STATUSES[goal.status]
                self._end(goal, end if end.ended else Ros2Status.ABORTED, result, now)
        return self._take_steps(now)

    # Time -------------------------------------------------------------------------------------------------------------

    def tick(self, now: float) -> list[Step]:
        """Return the actions that are due. Call this a few times per second."""
        for goal in [*self._goals.values()]:
            if not goal.is_active:
                if now - goal.ended_at > KEEP_TIME:
                    del self._goals[goal.uuid]
                continue
            if goal.call is not None:
                if goal.pending_since is not None and now - goal.pending_since >= PENDING_TIME:
                    self._accept(goal)
                elif goal.pending_since is None and now - goal.sent_at >= ACCEPT_TIME:
                    self._steps.append(SendCancel(goal.name, NO_STAMP))  # the goal must not run if it arrives late
                    self._refuse(goal)
            if goal.final_since is not None and now - goal.final_since >= RESULT_TIME:
                end = _ROS2_STATUSES[goal.status]
                self._end(goal, Ros2Status.ABORTED if end is Ros2Status.SUCCEEDED else end, None, now)
        return self._take_steps(now)

    def on_lost(self, now: float) -> list[Step]:
        """Record that the server is gone. Goals that come later are not accepted."""
        self._is_lost = True
        for goal in [*self._goals.values()]:
            if goal.call is not None:
                self._refuse(goal)
            elif goal.is_active:
                self._end(goal, Ros2Status.ABORTED, None, now)
        self._others = {}
        return self._take_steps(now)

    def close(self) -> list[Step]:
        """End all calls, since the bridge is shutting down."""
        text = "the bridge to ROS 1 is shutting down"
        steps: list[Step] = []
        for goal in self._goals.values():
            steps += [EndWithoutResponse(call, text) for call in (goal.call, *goal.waiting) if call is not None]
        self._goals = {}
        return steps

    # Goals ------------------------------------------------------------------------------------------------------------

    def _apply(self, goal: _Goal, reported: GoalStatus, now: float) -> None:
        if not goal.is_active or goal.final_since is not None or reported.status not in _ROS2_STATUSES:
            return
        goal.status = Status(reported.status)
        goal.stamp = reported.stamp
        if goal.call is not None:
            if goal.status in _REFUSED:
                self._refuse(goal)
                return
            if goal.status in (Status.PENDING, Status.RECALLING):
                goal.pending_since = now if goal.pending_since is None else goal.pending_since
            else:
                self._accept(goal)
        if goal.status.ended:
            goal.final_since = now

    def _accept(self, goal: _Goal) -> None:
        self._steps.append(AnswerGoal(goal.call, True, goal.stamp))
        goal.call = None
        goal.accepted = True

    def _refuse(self, goal: _Goal) -> None:
        self._steps.append(AnswerGoal(goal.call, False, goal.stamp))
        self._steps += [AnswerResult(call, Ros2Status.UNKNOWN, None) for call in goal.waiting]
        del self._goals[goal.uuid]

    def _end(self, goal: _Goal, end: Ros2Status, result: bytes | None, now: float) -> None:
        if goal.call is not None:
            self._accept(goal)
        goal.end, goal.result, goal.ended_at = end, result, now
        self._steps += [AnswerResult(call, end, result) for call in goal.waiting]
        goal.waiting.clear()
        self._goals[goal.uuid] = self._goals.pop(goal.uuid)  # move it to the end
        ended = [each for each in self._goals.values() if not each.is_active]
        num_bytes = sum(len(each.result or b"") for each in ended)
        for oldest in ended[:-1]:
            if len(ended) <= MAX_RESULTS and num_bytes <= MAX_RESULT_BYTES:
                break
            ended.remove(oldest)
            num_bytes -= len(oldest.result or b"")
            del self._goals[oldest.uuid]

    def _take_steps(self, now: float) -> list[Step]:
        """Return the collected actions, followed by one that publishes the status of all goals if that has changed."""
        goals = [
            each.to_status()
            for each in self._goals.values()
            if each.accepted and (each.is_active or now - each.ended_at <= REPORT_TIME)
        ]
        goals += [
            ReportedGoal(GoalInfo(uuid, each.stamp), _ROS2_STATUSES[Status(each.status)])
            for uuid, each in self._others.items()
        ]
        if tuple(goals) != self._last_statuses:
            self._last_statuses = tuple(goals)
            self._steps.append(SendStatuses(self._last_statuses))
        steps, self._steps = self._steps, []
        return steps


def _uuid(name: str) -> bytes:
    """Return the UUID for a goal in ROS 1: its name if that is a UUID, otherwise a hash of the name."""
    if len(name) == 2 * UUID_SIZE:
        try:
            uuid = bytes.fromhex(name)
        except ValueError:
            pass
        else:
            if uuid.hex() == name:
                return uuid
    return sha256(name.encode("utf-8", "surrogateescape")).digest()[:UUID_SIZE]
