"""A scheduler under a test's control: threads that run one at a time, in an order that a plan decides, by a clock of
their own.

Each task is a real thread, so thread identities and local variables are real; but all wait, except one. At each *point*
the plan may let another task go on. Points are the places in the modules under test at which CPython may let another
thread run (found by `sys.settrace`): the begin of a function, the instruction after a call, the jump back of a loop;
and each operation of the stand-ins for locks, sleeps and sockets (`stand_ins`, `network`, `polling`). Nothing really
waits: a task that would wait names its condition and its deadline, and when none can go on the clock jumps to the next
deadline.

A run is decided by the plan alone, so it can be repeated. It fails if no task can ever go on (deadlock), if it does not
end within LONGEST seconds of its clock or MAX_POINTS points (a wait that does not end, or tasks that keep each other
busy), and if a task raises.
"""

from __future__ import annotations

import _thread
import dis
import sys
import threading
import traceback
from collections.abc import Callable
from functools import cache
from types import CodeType
from typing import Any, Protocol

TICK = 1e-6
"""Seconds that a point takes."""
BEGIN = 1000.0
SLICE = 2000
"""Points after which another task goes on, whatever the plan says: as with CPython, none is stopped for ever."""
LONGEST = 1000.0
MAX_POINTS = 400_000
HIDDEN = (
    "/schedules/scheduler.py",
    "/schedules/stand_ins.py",
    "/schedules/network.py",
    "/schedules/polling.py",
    "/threading.py",
)
PATIENCE = 60.0
"""Real seconds for one run: longer means that something waits outside of the scheduler."""


class Plan(Protocol):
    """What decides a run."""

    def due(self, point: int) -> int:
        """Return the number of the next point at which to ask `preempt`, after ``point``."""

    def preempt(self, point: int, others: int) -> int:
        """Return 0 to let the task go on, or which of the others goes on, from 1."""

    def choose(self, point: int, ready: int) -> int:
        """Return which of the tasks that can go on does so, from 0, as the present one waits or has ended."""

    def delay(self) -> float:
        """Return the seconds for which a task that is preempted loses the processor."""

    def part(self, size: int) -> int:
        """Return how many of ``size`` waiting bytes one receive gets, at least 1."""


class Abandoned(BaseException):
    """Ends the tasks of a run that has failed."""


class Stuck(AssertionError):
    """A wait that does not end."""


class Task:
    """One thread of a run.

    Args:
        name: for reports.
        function: what it runs.
    """

    __slots__ = ("baton", "deadline", "ended", "function", "last", "name", "ready", "thread")

    def __init__(self, name: str, function: Callable[[], object]) -> None:
        self.name = name
        self.function = function
        self.baton = _thread.allocate_lock()
        self.baton.acquire()
        self.ready: Callable[[], object] | None = None  # None: it can go on
        self.deadline: float | None = None
        self.ended = False
        self.last = 0  # the point at which it ran last
        self.thread: threading.Thread | None = None


def _never() -> bool:
    return False


@cache
def switches_of(code: CodeType) -> frozenset[int]:
    """Return the places of the instructions before which CPython may let another thread run."""
    found, after_call = [], False
    for instruction in dis.get_instructions(code):
        back = instruction.opname.startswith(("JUMP", "POP_JUMP")) and (
            "BACKWARD" in instruction.opname or int(instruction.argval or 0) <= instruction.offset
        )
        if (after_call or back) and instruction.opname != "CACHE":
            found.append(instruction.offset)
            after_call = False
        after_call = after_call or (instruction.opname.startswith("CALL") and "INTRINSIC" not in instruction.opname)
    return frozenset(found)


class Scheduler:
    """One run.

    Args:
        plan: decides it.
        traced: file names of the modules under test.

    Attributes:
        now: the time, in seconds.
        points: the number of points so far.
        current: the task that runs.
        over: whether the run has ended; tasks that go on are then ended.
    """

    def __init__(self, plan: Plan, traced: frozenset[str]) -> None:
        self.now = BEGIN
        self.points = 0
        self.over = False
        self.tasks: list[Task] = []
        self.current: Task | None = None
        self.failure: BaseException | None = None
        self._plan = plan
        self._looking = False
        self._traced = traced
        self._tracers: dict[CodeType, Any] = {}
        self._due = plan.due(0)
        self._turn_over = SLICE
        self._done = _thread.allocate_lock()
        self._done.acquire()

    def run(self, main: Callable[[], object]) -> None:
        """Run a function as the first task, and all tasks that it starts, to their ends; raise what one of them raises.

        Raises:
            Stuck: a wait does not end.
        """
        first = self.current = self.start("main", main)
        first.baton.release()
        if not self._done.acquire(timeout=PATIENCE):
            self.fail(Stuck(f"something waits outside of the scheduler:{self.places()}"))
        for task in self.tasks:
            if task.thread is not None:
                task.thread.join(PATIENCE)
        if self.failure is not None:
            raise self.failure

    def start(self, name: str, function: Callable[[], object]) -> Task:
        """Start a task. It can go on at the next point."""
        task = Task(name, function)
        task.last = self.points
        self.tasks.append(task)
        task.thread = threading.Thread(target=self._begin, args=(task,), name=f"task {name}", daemon=True)
        task.thread.start()
        return task

    def _begin(self, task: Task) -> None:
        task.baton.acquire()
        try:
            if not self.over:
                sys.settrace(self._trace)
                try:
                    task.function()
                finally:
                    sys.settrace(None)
        except Abandoned:
            pass
        except BaseException as error:  # noqa: BLE001 - told by the run
            self.fail(error)
        task.ended = True
        if not self.over:
            self._next(task)

    # Points -----------------------------------------------------------------------------------------------------------

    def _trace(self, frame: Any, _event: str, _arg: object) -> Any:
        if frame.f_code.co_filename not in self._traced:
            return None
        frame.f_trace_opcodes = True
        frame.f_trace_lines = False
        self.point()
        return self._tracer(frame.f_code)

    def _tracer(self, code: CodeType) -> Any:
        """Return the function that is called before each instruction."""
        tracer = self._tracers.get(code)
        if tracer is None:
            switches, point = switches_of(code), self.point

            def tracer(frame: Any, event: str, _arg: object) -> Any:
                if event == "opcode" and frame.f_lasti in switches:
                    point()
                return tracer

            self._tracers[code] = tracer
        return tracer

    def point(self) -> None:
        """Let another task go on, if the plan says so."""
        if self._looking:
            return
        if self.over:
            raise Abandoned
        self.points += 1
        self.now += TICK
        if self.points >= self._due or self.points >= self._turn_over:
            self._preempt()

    def _preempt(self) -> None:
        me = self.current
        assert me is not None
        if self.points > MAX_POINTS:
            self._give_up(f"not over after {MAX_POINTS} points")
        others = self._able(me)
        chosen = 1
        if self.points < self._turn_over:
            chosen = self._plan.preempt(self.points, len(others))
            self._due = self._plan.due(self.points)
        else:
            self._turn_over = self.points + SLICE
        if chosen and others:
            delay = self._plan.delay()
            if delay:  # as if the system gave the processor to other programs
                me.ready, me.deadline = _never, self.now + delay
            self._hand_to(others[(chosen - 1) % len(others)])
            me.ready = me.deadline = None

    def wait(self, ready: Callable[[], object], timeout: float | None = None) -> bool:
        """Wait until a condition is true; return whether it is.

        Args:
            timeout: seconds by the run's clock; None: no limit.
        """
        self.point()
        if ready():
            return True
        if timeout is not None and timeout <= 0:
            return False
        me = self.current
        assert me is not None
        me.ready, me.deadline = ready, None if timeout is None else self.now + timeout
        self._next(me)
        me.ready = me.deadline = None
        return bool(ready())

    def pause(self, seconds: float) -> None:
        """Sleep; without seconds, let another task go on."""
        if seconds > 0:
            self.wait(_never, seconds)
            return
        self.point()
        me = self.current
        assert me is not None
        others = self._able(me)
        if others:
            self._hand_to(others[self._plan.choose(self.points, len(others)) % len(others)])

    # Turns ------------------------------------------------------------------------------------------------------------

    def _able(self, but: Task | None = None) -> list[Task]:
        """Return the tasks that can go on, those first that have waited longest."""
        now = self.now
        self._looking = True  # conditions may call what is under test
        able = [
            task
            for task in self.tasks
            if not task.ended
            and task is not but
            and (task.ready is None or (task.deadline is not None and task.deadline <= now) or task.ready())
        ]
        self._looking = False
        able.sort(key=lambda task: task.last)
        return able

    def _next(self, me: Task) -> None:
        """Let another task go on, since the present one waits or has ended."""
        self.points += 1
        self.now += TICK
        able = self._able()
        if not able:
            deadlines = [task.deadline for task in self.tasks if not task.ended and task.deadline is not None]
            if not deadlines:
                if all(task.ended for task in self.tasks):
                    self.over = True
                    self._done.release()
                    return
                self._give_up("deadlock", raising=not me.ended)
                return
            self.now = max(self.now, min(deadlines))
            able = self._able()
        if self.now > BEGIN + LONGEST or self.points > MAX_POINTS:
            self._give_up(f"not over after {LONGEST:g} s and {self.points} points", raising=not me.ended)
            return
        chosen = able[0] if len(able) == 1 else able[self._plan.choose(self.points, len(able)) % len(able)]
        if chosen is not me:
            self._hand_to(chosen, wait=not me.ended)

    def _hand_to(self, task: Task, wait: bool = True) -> None:
        me = self.current
        assert me is not None
        me.last = self.points
        self._turn_over = self.points + SLICE
        self.current = task
        task.baton.release()
        if wait:
            me.baton.acquire()
            if self.over:
                raise Abandoned

    # Failures ---------------------------------------------------------------------------------------------------------

    def _give_up(self, what: str, raising: bool = True) -> None:
        self.fail(Stuck(f"{what}:{self.places()}"))
        if raising:
            raise Abandoned

    def fail(self, error: BaseException) -> None:
        """End the run, which has failed."""
        if self.over:
            return
        self.over = True
        self.failure = error
        for task in self.tasks:
            if task is not self.current and not task.ended:
                task.baton.release()
        self._done.release()

    def places(self) -> str:
        """Return where each task is."""
        frames = sys._current_frames()
        text = ""
        for task in self.tasks:
            frame = frames.get(task.thread.ident or 0) if task.thread is not None else None
            if task.ended or frame is None:
                continue
            stack = [each for each in traceback.extract_stack(frame) if not each.filename.endswith(HIDDEN)]
            where = " < ".join(
                f"{each.filename.rpartition('/')[2]}:{each.lineno} {each.name}" for each in stack[:-9:-1]
            )
            text += f"\n  {task.name}: {where}"
        return text
