"""The stage: puts the stand-ins into the modules of pyros1, and runs scenarios on it, each with a plan."""

from __future__ import annotations

import contextlib
import gc
import queue
import select
import selectors
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from . import network, polling, stand_ins
from .network import Network
from .scheduler import Plan, Scheduler
from .socket_module import SocketModule

ROOMS = ("pyros1.net.", "pyros1.node.", "pyros1.master.", "pyros1.actions.", "pyros1.bag.record.", "pyros1.web.")


class Stage:
    """What a scenario has at hand in one run.

    Attributes:
        scheduler: the run.
        network: its sockets.
        threading: the stand-in for that module.
        told: lines of logs.
    """

    def __init__(self) -> None:
        self.scheduler: Scheduler = None  # type: ignore[assignment]  # before the first run
        self.network: Network = None  # type: ignore[assignment]
        self.told: list[str] = []
        self.threading = stand_ins.Threading(lambda: self.scheduler)
        self.queue = stand_ins.Queues(lambda: self.scheduler)
        self.time = stand_ins.Time(lambda: self.scheduler)
        self.socket = SocketModule(lambda: self.network)
        self.select = polling.SelectModule(lambda: self.network)
        self.selectors = polling.SelectorsModule(lambda: self.network)

    def run(self, scenario: Scenario, plan: Plan) -> Scheduler:
        """Run a scenario with a plan, and return what happened.

        Raises:
            Stuck: a wait does not end.
            AssertionError: an invariant does not hold.
        """
        self.scheduler = Scheduler(plan, scenario.traced)
        self.network = Network(self.scheduler, plan.part, scenario.room)
        self.threading.forget()
        self.told.clear()
        gc.disable()  # what it ends would run in the middle of anything
        try:
            self.scheduler.run(lambda: self._play(scenario))
        finally:
            gc.enable()
        assert not self.network.files, f"left open: {list(self.network.files.values())}"
        return self.scheduler

    def _play(self, scenario: Scenario) -> None:
        self.threading.current_thread()
        scenario.play(self)

    def spawn(self, *functions: Callable[[], object]) -> list[Any]:
        """Start a thread for each function; return the threads."""
        threads = []
        for number, function in enumerate(functions):
            name = f"{getattr(function, '__name__', 'task')}{number}"
            threads.append(self.threading.Thread(target=function, name=name))
            threads[-1].start()
        return threads

    def together(self, *functions: Callable[[], object]) -> None:
        """Run functions at the same time, to their ends."""
        for thread in self.spawn(*functions):
            thread.join()

    def until(self, condition: Callable[[], object], seconds: float = 60.0) -> None:
        """Wait for a condition; fail after some seconds of the run's clock."""
        end = self.scheduler.now + seconds
        while not self.scheduler.wait(condition, end - self.scheduler.now):
            if self.scheduler.now >= end:
                raise AssertionError(f"not within {seconds:g} s:{self.scheduler.places()}")


class Scenario:
    """What is played, with any plan; a subclass for each.

    Attributes:
        modules: those of pyros1 whose instructions are points.
        limits: names of limits of modules that are small here, so that few messages reach them: (module, name, value).
        room: bytes that wait in a connection.
    """

    modules: tuple[str, ...] = ()
    limits: tuple[tuple[str, str, object], ...] = ()
    room = network.ROOM

    def __init__(self) -> None:
        files = (__import__(name, fromlist=["__file__"]).__file__ for name in self.modules)
        self.traced = frozenset(str(file) for file in files)

    def play(self, stage: Stage) -> None:
        """Play it, and check the invariants. All threads that it starts must end."""
        raise NotImplementedError


@contextlib.contextmanager
def stage_for(scenario: Scenario) -> Iterator[Stage]:
    """Put the stand-ins into all modules of pyros1 that are loaded, and the scenario's limits; undo that at the end."""
    stage = Stage()
    undo: list[tuple[Any, str, Any]] = []

    def put(module: Any, name: str, value: Any) -> None:
        undo.append((module, name, getattr(module, name)))
        setattr(module, name, value)

    try:
        _put_stand_ins(stage, put)
        for name, limit, value in scenario.limits:
            put(sys.modules[name], limit, value)
        yield stage
    finally:
        for module, name, value in reversed(undo):
            setattr(module, name, value)


def _put_stand_ins(stage: Stage, put: Callable[[Any, str, Any], None]) -> None:
    import pyros1.net.loop
    import pyros1.net.spin_wait

    class LoopThread(stage.threading.Thread):  # type: ignore[name-defined,misc]
        owner: object | None = None

    stand_in = {
        id(threading): stage.threading,
        id(queue): stage.queue,
        id(time): stage.time,
        id(socket): stage.socket,
        id(select): stage.select,
        id(selectors): stage.selectors,
        id(time.monotonic): stage.time.monotonic,
        id(time.perf_counter): stage.time.perf_counter,
        id(time.time): stage.time.time,
        id(time.time_ns): stage.time.time_ns,
        id(pyros1.net.loop.LoopThread): LoopThread,
    }
    for module_name, module in list(sys.modules.items()):
        if not module_name.startswith(ROOMS):
            continue
        for name, value in list(vars(module).items()):
            if id(value) in stand_in:
                put(module, name, stand_in[id(value)])
    put(pyros1.net.loop, "yield_processor", lambda: stage.time.sleep(0))
    put(pyros1.net.spin_wait, "yield_processor", lambda: stage.time.sleep(0))
