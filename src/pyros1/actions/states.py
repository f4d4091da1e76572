"""Goal states in clients and servers, and their transitions.

The server publishes each goal's status; the client derives from it the stage of its conversation with the server
(https://wiki.ros.org/actionlib/DetailedDescription).
"""

from __future__ import annotations

from enum import Enum, IntEnum


class Status(IntEnum):
    """Status of a goal in the server: the values of actionlib_msgs/GoalStatus."""

    PENDING = 0
    ACTIVE = 1
    PREEMPTED = 2
    SUCCEEDED = 3
    ABORTED = 4
    REJECTED = 5
    PREEMPTING = 6
    RECALLING = 7
    RECALLED = 8
    LOST = 9

    @property
    def ended(self) -> bool:
        """Whether this status is final."""
        return self in _FINAL_STATUSES


_FINAL_STATUSES = frozenset(
    {Status.PREEMPTED, Status.SUCCEEDED, Status.ABORTED, Status.REJECTED, Status.RECALLED, Status.LOST}
)


class Stage(IntEnum):
    """Stage of a goal in the client; the numbers are those of stock ROS's CommState."""

    WAITING_FOR_GOAL_ACK = 0
    PENDING = 1
    ACTIVE = 2
    WAITING_FOR_RESULT = 3
    WAITING_FOR_CANCEL_ACK = 4
    RECALLING = 5
    PREEMPTING = 6
    DONE = 7


class Transition(Enum):
    """A change of a goal's status, made by the server or requested by a client."""

    ACCEPT = "accept"
    REJECT = "reject"
    ABORT = "abort"
    SUCCEED = "succeed"
    CANCEL = "cancel"  # the server has stopped the goal
    ASK_TO_CANCEL = "ask to cancel"


_TRANSITIONS: dict[Transition, dict[Status, Status]] = {
    Transition.ACCEPT: {Status.PENDING: Status.ACTIVE, Status.RECALLING: Status.PREEMPTING},
    Transition.REJECT: dict.fromkeys((Status.PENDING, Status.RECALLING), Status.REJECTED),
    Transition.ABORT: dict.fromkeys((Status.ACTIVE, Status.PREEMPTING), Status.ABORTED),
    Transition.SUCCEED: dict.fromkeys((Status.ACTIVE, Status.PREEMPTING), Status.SUCCEEDED),
    Transition.CANCEL: dict.fromkeys((Status.PENDING, Status.RECALLING), Status.RECALLED)
    | dict.fromkeys((Status.ACTIVE, Status.PREEMPTING), Status.PREEMPTED),
    Transition.ASK_TO_CANCEL: {Status.PENDING: Status.RECALLING, Status.ACTIVE: Status.PREEMPTING},
}


def status_after(status: int, transition: Transition) -> Status | None:
    """Return the status after a transition; None if the transition is not possible now."""
    return _TRANSITIONS[transition].get(Status(status)) if 0 <= status <= Status.LOST else None


_STAGE_BY_LETTER = {
    "P": Stage.PENDING,
    "A": Stage.ACTIVE,
    "R": Stage.RECALLING,
    "X": Stage.PREEMPTING,
    "W": Stage.WAITING_FOR_RESULT,
}
# A column for each stage except DONE, a row for each status that a server may publish. The letters are the next stages
# in order: the client passes through each of them even if it has missed messages. "." means no change, "!" a protocol
# violation.
_TABLE_COLUMNS = (
    Stage.WAITING_FOR_GOAL_ACK,
    Stage.PENDING,
    Stage.ACTIVE,
    Stage.WAITING_FOR_RESULT,
    Stage.WAITING_FOR_CANCEL_ACK,
    Stage.RECALLING,
    Stage.PREEMPTING,
)
_TABLE_ROWS = {
    Status.PENDING: "P   .   !  ! .  !  !",
    Status.ACTIVE: "A   A   .  . .  !  !",
    Status.RECALLING: "PR  R   !  ! R  .  !",
    Status.PREEMPTING: "AX  AX  X  ! X  X  .",
    Status.REJECTED: "PW  W   !  . W  W  !",
    Status.RECALLED: "PW  RW  !  . RW W  !",
    Status.PREEMPTED: "AXW AXW XW . XW XW W",
    Status.SUCCEEDED: "AW  AW  W  . XW XW W",
    Status.ABORTED: "AW  AW  W  . XW XW W",
}
_NEXT_STAGES: dict[tuple[int, int], tuple[Stage, ...] | None] = {
    (stage, status): None if cell == "!" else tuple(_STAGE_BY_LETTER[letter] for letter in cell if letter != ".")
    for status, row in _TABLE_ROWS.items()
    for stage, cell in zip(_TABLE_COLUMNS, row.split(), strict=True)
}


def stages_after(stage: int, status: int) -> tuple[Stage, ...] | None:
    """Return the stages that a goal goes through when a status arrives from the server.

    Args:
        stage: the current stage.
        status: the server's status.

    Returns:
        The stages in order, often none; None if the protocol does not allow this status now.
    """
    if stage == Stage.DONE:
        return () if status in _FINAL_STATUSES and status != Status.LOST else None
    return _NEXT_STAGES.get((stage, status))
