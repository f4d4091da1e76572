"""One board: its topics and services in ROS; carries out the actions of its session."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from pyros1.diagnostics import ERROR, OK, Status
from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line
from pyros1.msgs.rosserial_msgs.msg import TopicInfo
from pyros1.msgs.std_msgs.msg import Time
from pyros1.node import Node
from pyros1.node.log.levels import ERROR as LOG_ERROR
from pyros1.robot_nodes.rosserial_python import session as to_do
from pyros1.robot_nodes.rosserial_python.endpoints import Endpoints
from pyros1.robot_nodes.rosserial_python.frames import MAX_DATA, encode_frame
from pyros1.robot_nodes.rosserial_python.log_budget import LogBudget
from pyros1.robot_nodes.rosserial_python.parameters import parameter_response
from pyros1.robot_nodes.rosserial_python.ports import Port, PortError
from pyros1.robot_nodes.rosserial_python.servers import Servers
from pyros1.robot_nodes.rosserial_python.session import STOP_REQUEST, Session

_MAX_JOBS = 20
"""Maximum number of service calls and parameters that wait for ROS; a board rarely has more than one."""
_LEVELS = ("debug", "info", "warn", "error", "fatal")


class Board:
    """The host's side of the link to one board.

    Args:
        node: the node that has the board's topics and services.
        name: the port, for the log and diagnostics.
        hint: what the user should check if the received bytes are not rosserial's protocol.
        changed: called when the status has changed.
        servers: the services of all the node's boards.
    """

    def __init__(self, node: Node, name: str, hint: str, changed: Callable[[], None], servers: Servers) -> None:
        self._node = node
        self._name = name
        self._changed = changed
        self._session = Session(hint)
        self._port: Port | None = None
        self._write_lock = threading.Lock()
        self._problem = "not connected"
        self._last_sync = self._last_lost = 0.0
        self._jobs: queue.Queue[Callable[[], None] | None] = queue.Queue(_MAX_JOBS)
        self._endpoints = Endpoints(node, self.send, self._submit, servers, name)
        self._log_budget = LogBudget(time.monotonic())
        self._worker = threading.Thread(target=self._work, name=f"{node.name}:board calls", daemon=True)
        self._worker.start()

    def run(self, port: Port, end_if_lost: bool = False) -> None:
        """Exchange frames with the board until the node shuts down.

        Args:
            port: the connection, which the caller closes.
            end_if_lost: whether to return if the board is silent for too long.

        Raises:
            PortError: the connection broke.
        """
        self._port = port
        was_synced = False
        try:
            self._carry_out(self._session.start(time.monotonic()))
            while self._node.ok():
                data = port.read()
                now = time.monotonic()
                if data:
                    self._carry_out(self._session.receive(data, now))
                self._carry_out(self._session.tick(now))
                synced = self._session.is_synced
                if was_synced and not synced:
                    self._last_lost = time.time()
                if end_if_lost and self._session.is_lost:
                    return
                if synced and data:
                    self._last_sync = time.time()
                self.set_problem("" if synced else "no sync with device")
                was_synced = synced
            self._write(STOP_REQUEST)
        except PortError:
            self._last_lost = time.time()
            raise
        finally:
            self._port = None
            self._endpoints.on_disconnected()

    def set_problem(self, problem: str) -> None:
        """Set the reason for the missing connection, for the diagnostics; empty while connected."""
        if problem != self._problem:
            self._problem = problem
            self._changed()

    def close(self) -> None:
        """Remove the board's topics and services."""
        self._endpoints.close()
        with self._jobs.mutex:
            self._jobs.queue.clear()
        self._jobs.put(None)
        self._worker.join(1.0)

    def send(self, topic_id: int, data: bytes) -> bool:
        """Send a message to the board; return whether it was sent."""
        if len(data) > MAX_DATA:
            self._node.log.error("a message of %d bytes is too large for the board", len(data), throttle=10)
            return False
        return self._write(encode_frame(topic_id, data))

    def _write(self, frame: bytes) -> bool:
        port = self._port
        if port is None:
            return False
        try:
            with self._write_lock:
                port.write(frame)
        except PortError as error:  # if the connection is broken, `run` reports it
            self._node.log.debug("%s: %s", self._name, error)
            return False
        return True

    # The session's actions --------------------------------------------------------------------------------------------

    def _carry_out(self, actions: list[to_do.Action]) -> None:
        log = self._node.log
        for action in actions:
            match action:
                case to_do.Send():
                    self._write(action.data)
                case to_do.Deliver():
                    self._endpoints.deliver(action.endpoint, action.data)
                case to_do.SetUp():
                    self._endpoints.set_up(action.endpoint)
                case to_do.SendTime():
                    now = Time(self._node.now())
                    self.send(TopicInfo.ID_TIME, Time._encode(now))
                case to_do.SendParameter():
                    self._submit(partial(self._send_parameter, action.name))
                case to_do.Say():
                    log.peer_event(1 << action.level, "%s: %s", self._name, action.text, link=self._name)
                case to_do.BoardLog():
                    self._log(min(action.level, 4), one_line(action.text, 1000))

    def _log(self, level: int, text: str) -> None:
        """Log a line from the board's program, unless there are too many."""
        if not self._log_budget.allows(time.monotonic()):
            return
        if dropped := self._log_budget.take_dropped():
            self._node.log.warn("%s: dropped %d log lines, since there were too many", self._name, dropped)
        getattr(self._node.log, _LEVELS[level])("%s", text)

    def _send_parameter(self, name: str) -> None:
        response = parameter_response(name, self._node.params.get(name))
        self.send(TopicInfo.ID_PARAMETER_REQUEST, type(response)._encode(response))

    # Calls into ROS ---------------------------------------------------------------------------------------------------

    def _submit(self, job: Callable[[], None]) -> None:
        try:
            self._jobs.put_nowait(job)
        except queue.Full:
            self._node.log.error("%s: the board calls faster than ROS responds", self._name, throttle=10)

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            try:
                job()
            except (Error, TypeError, ValueError) as error:
                if self._node.ok():
                    self._node.log.peer_event(LOG_ERROR, "%s: %s", self._name, error, link=self._name)

    def status(self) -> Any:
        """Return a DiagnosticStatus like stock's, with the times of the last sync and the last loss of it."""
        status = Status(name="rosserial_python", hardware_id=self._name)
        status.summary(ERROR if self._problem else OK, self._problem or "connected")
        status.add("last sync", time.ctime(self._last_sync) if self._last_sync else "never")
        status.add("last sync lost", time.ctime(self._last_lost) if self._last_lost else "never")
        return status
