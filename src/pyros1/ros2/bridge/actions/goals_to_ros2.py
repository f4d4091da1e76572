"""The goals that clients in ROS 1 send to an action server in ROS 2. No I/O, no clock.

ROS 1 clients publish goals and cancel requests, and expect the status of all goals several times per second, as from a
ROS 1 action server; the ROS 2 server is called through services.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

from pyros1.actions.states import Status
from pyros1.ros2.bridge.actions.ros1_messages import NO_STAMP, GoalStatus, Stamp
from pyros1.ros2.bridge.actions.ros2_messages import GoalInfo, ReportedGoal, Ros2Status

KEEP_TIME = 5.0
"""Seconds for which the status of an ended goal is still published, as by ROS 1 action servers."""
STATUS_PERIOD = 0.2
"""Seconds between status messages, as with ROS 1 action servers; one is also published after each change."""
RESULT_TIME = 10.0
"""Seconds to wait for the result after the status of its goal has become final."""
RETRY_TIME = 1.0
"""Seconds after which an unanswered request for a result is repeated."""
MAX_RETRIES = 5
LONG_TIME = 30.0
"""A request for a result that remains unanswered for at least this many seconds does not count as failed: the goal runs
long.
"""
MAX_GOALS = 256
"""Maximum number of active goals, and of unanswered requests for results; further goals are rejected."""
MAX_ENDED = 1000
MAX_EARLY = 100
"""Maximum number of goals remembered as cancelled before they arrived."""

_STATUSES = {
    Ros2Status.ACCEPTED: Status.PENDING,
    Ros2Status.EXECUTING: Status.ACTIVE,
    Ros2Status.CANCELING: Status.PREEMPTING,
    Ros2Status.SUCCEEDED: Status.SUCCEEDED,
    Ros2Status.CANCELED: Status.PREEMPTED,
    Ros2Status.ABORTED: Status.ABORTED,
}
_TOO_MANY = "the bridge to ROS 2 has too many goals of this action"
_NO_RESULT = "no result has come from ROS 2"
_RECALLED = "it was cancelled before it arrived"


class CallGoal(NamedTuple):
    """Send a goal to the server in ROS 2."""

    uuid: bytes
    goal: bytes


class CallResult(NamedTuple):
    """Ask for the result of a goal."""

    uuid: bytes


class CallCancel(NamedTuple):
    """Ask the server to cancel a goal."""

    uuid: bytes


class PublishResult(NamedTuple):
    """Publish a result in ROS 1; an empty one if it is None."""

    status: GoalStatus
    result: bytes | None


class PublishFeedback(NamedTuple):
    """Publish feedback in ROS 1."""

    status: GoalStatus
    feedback: bytes


class PublishStatuses(NamedTuple):
    """Publish the status of all goals in ROS 1."""

    statuses: tuple[GoalStatus, ...]


Step = CallGoal | CallResult | CallCancel | PublishResult | PublishFeedback | PublishStatuses


@dataclass
class _Goal:
    name: str
    stamp: Stamp
    uuid: bytes
    status: Status = Status.PENDING
    text: str = ""
    is_accepted: bool = False
    is_cancelled: bool = False  # whether a client asked to cancel it before it was accepted
    final: Status | None = None  # as reported by the server, until the result arrives
    final_since: float = 0.0
    asked_at: float = 0.0
    retry_at: float | None = None
    retries: int = 0
    ended_at: float | None = None

    def to_status(self) -> GoalStatus:
        return GoalStatus(self.name, self.stamp, int(self.status), self.text)


class GoalsToRos2:
    """The state of the goals of one action server. Each method returns the actions to perform, in order.

    Goals from ROS 2 clients are reported to ROS 1, too; their names are their UUIDs in hexadecimal digits.

    Times are in seconds, from any clock that does not go back; stamps are ROS times.

    Args:
        make_uuid: returns a new random UUID of 16 bytes.
    """

    def __init__(self, make_uuid: Callable[[], bytes]) -> None:
        self._make_uuid = make_uuid
        self._goals: dict[str, _Goal] = {}  # ended goals, in the order in which they ended
        self._by_uuid: dict[bytes, _Goal] = {}
        self._others: dict[str, ReportedGoal] = {}
        self._early: dict[str, float] = {}  # unknown goals that were cancelled, and when
        self._last_cancel = NO_STAMP
        self._asked: set[bytes] = set()  # goals whose results we have requested but not received
        self._last_statuses: tuple[GoalStatus, ...] | None = None
        self._next_status = 0.0
        self._steps: list[Step] = []

    # Messages from the ROS 1 side -------------------------------------------------------------------------------------

    def on_goal(self, name: str, stamp: Stamp, body: bytes, now: float, ros_now: Stamp) -> list[Step]:
        """Handle a goal.

        Args:
            name, stamp: its id; an empty name is replaced by a new one, and a zero stamp by the current time.
            body: the encoded goal.
            now, ros_now: the current time, in seconds and as a stamp.
        """
        if name in self._goals or name in self._others:
            return []
        uuid = self._make_uuid()
        goal = _Goal(name or uuid.hex(), ros_now if stamp == NO_STAMP else stamp, uuid)
        num_active = sum(each.ended_at is None for each in self._goals.values())
        if num_active >= MAX_GOALS or len(self._asked) >= MAX_GOALS:
            return [PublishResult(goal.to_status()._replace(status=int(Status.REJECTED), text=_TOO_MANY), None)]
        self._goals[goal.name] = self._by_uuid[uuid] = goal
        if self._early.pop(name, None) is not None or NO_STAMP != stamp <= self._last_cancel:
            self._end(goal, Status.RECALLED, None, _RECALLED, now)
        else:
            self._steps.append(CallGoal(uuid, body))
        return self._take_steps(now)

    def on_cancel(self, name: str, stamp: Stamp, now: float) -> list[Step]:
        """Handle a cancel request, which is for one goal, for all goals up to a time, for both, or, if it names
        neither, for all goals.
        """
        self._last_cancel = max(self._last_cancel, stamp)
        is_all = not name and stamp == NO_STAMP
        for goal in self._goals.values():
            if goal.ended_at is None and (is_all or goal.name == name or NO_STAMP != goal.stamp <= stamp):
                self._cancel(goal)
        for other_name, other in self._others.items():
            is_meant = is_all or other_name == name or NO_STAMP != other.info.stamp <= stamp
            if is_meant and other.status in (Ros2Status.ACCEPTED, Ros2Status.EXECUTING):
                self._steps.append(CallCancel(other.info.uuid))
        if name and name not in self._goals and name not in self._others:
            if len(self._early) >= MAX_EARLY:
                del self._early[next(iter(self._early))]
            self._early[name] = now
        return self._take_steps(now)

    def _cancel(self, goal: _Goal) -> None:
        if not goal.is_accepted:
            goal.is_cancelled = True
            goal.status = Status.RECALLING
        elif goal.status is not Status.PREEMPTING:
            # The server decides whether to cancel; until then, the status stays the same.
            self._steps.append(CallCancel(goal.uuid))

    # Messages from the ROS 2 side -------------------------------------------------------------------------------------

    def on_goal_response(self, uuid: bytes, accepted: bool | None, text: str, now: float) -> list[Step]:
        """Handle the response to a goal. ``accepted`` is None if there was no response, for the reason ``text``."""
        goal = self._by_uuid.get(uuid)
        if goal is None or goal.ended_at is not None:
            return [CallCancel(uuid)] if accepted else []  # its client has already been told that it has ended
        if goal.is_accepted:
            return []
        if accepted is None:
            self._steps.append(CallCancel(uuid))  # the goal must not run if the server did receive it
            self._end(goal, Status.ABORTED, None, text, now)
        elif not accepted:
            self._end(goal, Status.REJECTED, None, text or "the server in ROS 2 has rejected it", now)
        else:
            goal.is_accepted = True
            goal.status = Status.PREEMPTING if goal.is_cancelled else Status.ACTIVE
            self._ask(goal, now)
            if goal.is_cancelled:
                self._steps.append(CallCancel(uuid))
        return self._take_steps(now)

    def on_result(self, uuid: bytes, status: int | None, result: bytes, text: str, now: float) -> list[Step]:
        """Handle the result of a goal.

        Args:
            uuid: the goal.
            status: how it has ended; None if the server has not responded.
            result: the encoded result.
            text: why it has not responded.
            now: the time.
        """
        self._asked.discard(uuid)
        goal = self._by_uuid.get(uuid)
        if goal is None or goal.ended_at is not None:
            return self._take_steps(now)
        if status is None:
            goal.retries = 0 if now - goal.asked_at >= LONG_TIME else goal.retries + 1
            if goal.retries <= MAX_RETRIES:
                goal.retry_at = now + RETRY_TIME
            else:
                self._end(goal, Status.ABORTED, None, text, now)
        else:
            end = _STATUSES.get(Ros2Status(status)) if Ros2Status.UNKNOWN < status <= Ros2Status.ABORTED else None
            if end is not None and end.ended:
                self._end(goal, end, result, "", now)
            else:
                self._end(goal, Status.ABORTED, None, "the server in ROS 2 does not know the goal", now)
        return self._take_steps(now)

    def on_cancel_response(self, uuid: bytes, goals: Iterable[GoalInfo], now: float) -> list[Step]:
        """Handle the response to a cancel request: the goals that the server is now cancelling."""
        goal = self._by_uuid.get(uuid)
        if goal is not None and goal.ended_at is None and any(each.uuid == uuid for each in goals):
            goal.status = Status.PREEMPTING
        return self._take_steps(now)

    def on_feedback(self, uuid: bytes, feedback: bytes) -> list[Step]:
        """Pass on feedback on a goal that a ROS 1 client has sent."""
        goal = self._by_uuid.get(uuid)
        return [] if goal is None or goal.ended_at is not None else [PublishFeedback(goal.to_status(), feedback)]

    def on_statuses(self, goals: Iterable[ReportedGoal], now: float) -> list[Step]:
        """Record the status of all goals that the server knows."""
        self._others = {}
        for reported in goals:
            if not Ros2Status.UNKNOWN < reported.status <= Ros2Status.ABORTED:
                continue
            goal = self._by_uuid.get(reported.info.uuid)
            if goal is None:
                if len(self._others) < MAX_GOALS:
                    self._others[reported.info.uuid.hex()] = reported
            elif goal.is_accepted and goal.ended_at is None:
                status = _STATUSES[Ros2Status(reported.status)]
                if status.ended:
                    goal.final_since = now if goal.final is None else goal.final_since
                    goal.final = status
                elif status is Status.PREEMPTING:
                    goal.status = status
        return self._take_steps(now)

    # Time -------------------------------------------------------------------------------------------------------------

    def tick(self, now: float) -> list[Step]:
        """Return the actions that are due. Call this a few times per second."""
        for goal in [*self._goals.values()]:
            if goal.ended_at is not None:
                if now - goal.ended_at > KEEP_TIME:
                    self._forget(goal)
            elif goal.final is not None and now - goal.final_since >= RESULT_TIME:
                end = Status.ABORTED if goal.final is Status.SUCCEEDED else goal.final
                self._end(goal, end, None, _NO_RESULT, now)
            elif goal.retry_at is not None and now >= goal.retry_at:
                self._ask(goal, now)
        self._early = {name: at for name, at in self._early.items() if now - at <= KEEP_TIME}
        if now >= self._next_status:
            self._last_statuses = None
        return self._take_steps(now)

    def on_lost(self, text: str, now: float) -> list[Step]:
        """Record that the server is gone, and will not answer any requests."""
        for goal in [*self._goals.values()]:
            if goal.ended_at is None:
                self._end(goal, Status.ABORTED, None, text, now)
        self._others = {}
        return self._take_steps(now)

    # Goals ------------------------------------------------------------------------------------------------------------

    def _ask(self, goal: _Goal, now: float) -> None:
        goal.asked_at, goal.retry_at = now, None
        self._asked.add(goal.uuid)
        self._steps.append(CallResult(goal.uuid))

    def _end(self, goal: _Goal, status: Status, result: bytes | None, text: str, now: float) -> None:
        goal.status, goal.text, goal.ended_at = status, text, now
        self._goals[goal.name] = self._goals.pop(goal.name)  # move it to the end
        self._steps.append(PublishResult(goal.to_status(), result))
        ended = [each for each in self._goals.values() if each.ended_at is not None]
        for oldest in ended[: max(0, len(ended) - MAX_ENDED)]:
            self._forget(oldest)

    def _forget(self, goal: _Goal) -> None:
        del self._goals[goal.name], self._by_uuid[goal.uuid]

    def _take_steps(self, now: float) -> list[Step]:
        """Return the collected actions, and one that publishes the status of all goals if it has changed or is due."""
        statuses = [goal.to_status() for goal in self._goals.values()]
        statuses += [
            GoalStatus(name, each.info.stamp, int(_STATUSES[Ros2Status(each.status)]))
            for name, each in self._others.items()
        ]
        if tuple(statuses) != self._last_statuses:
            self._last_statuses = tuple(statuses)
            self._next_status = now + STATUS_PERIOD
            self._steps.append(PublishStatuses(self._last_statuses))
        steps, self._steps = self._steps, []
        return steps
