"""Runs the master and the rosout node inside this process (X78-X80, L14)."""

from __future__ import annotations

import errno
import os
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from pyros1.ground import terminal_text
from pyros1.ground.errors import Error, LaunchError
from pyros1.ground.log_file import LogFile
from pyros1.net.background_writer import BackgroundWriter, Item, ShouldStop, write_to_terminal
from pyros1.net.hosts import LocalAddress

if TYPE_CHECKING:
    from pyros1.launch.running.core_journal import CoreJournal
    from pyros1.net.allowlist import Allowlist
    from pyros1.node.node import Node

LOG_LEVELS = ("debug", "info", "warn", "error", "fatal")
MASTER_LOG_SIZE = 100_000_000
"""Maximum size of master.log in bytes."""
MASTER_LOG_PARTS = 10
"""Number of older log files to keep."""
MAX_LINE_LENGTH = 100_000
"""Maximum number of characters per line in master.log."""
ROSVERSION = "1.16.0\n"
ROSDISTRO = "noetic\n"
RESTART_DELAY_S = 0.2
"""Seconds before the rosout node is restarted, so that other nodes with its name cannot keep the core busy."""
CORE_PARAMS = {"/rosdistro": ROSDISTRO, "/rosversion": ROSVERSION}
"""Parameters that a core sets in addition to /run_id. The newlines are part of the values, as in stock ROS."""


class Core:
    """A master with its rosout node.

    Args:
        port: port to listen on.
        address: addresses to listen on and to advertise.
        uri: the master's URI, as given to nodes.
        log_folder: folder of master.log and rosout.log.
        environ: this process's environment.
        on_shutdown: called with the reason when a client asks the master to shut down.
        notify_timeout: maximum number of seconds for a node to respond to a notification; None for the default.
        log_level: minimum level in master.log: debug (includes each call to the master), info, warn, error or fatal.
        allowlist: decides which hosts may connect to the master; None admits all.
        core_journal: the journal and the state to restore; None for no journal.
    """

    def __init__(
        self,
        *,
        port: int,
        address: LocalAddress,
        uri: str,
        log_folder: Path,
        environ: Mapping[str, str],
        on_shutdown: Callable[[str], object],
        notify_timeout: float | None = None,
        log_level: str = "info",
        core_journal: CoreJournal | None = None,
        allowlist: Allowlist | None = None,
    ) -> None:
        from pyros1.master.server import NOTIFY_TIMEOUT_S, Master  # noqa: PLC0415 - only if no master runs yet

        self._log_folder = log_folder
        self._log = LogFile(str(log_folder / "master.log"), MASTER_LOG_SIZE, MASTER_LOG_PARTS)
        # Separate threads, since the master's loop must not wait for a disk or a terminal.
        self._log_writer = BackgroundWriter("master:log", self._write_items)
        self._terminal_writer = BackgroundWriter("master:screen", write_to_terminal)
        self._master = Master(
            port=port,
            bind_host=address.bind,
            advertised_host=address.advertised,
            log=self._write_log,
            on_shutdown=on_shutdown,
            notify_timeout=NOTIFY_TIMEOUT_S if notify_timeout is None else notify_timeout,
            log_calls=log_level == "debug",
            journal=None if core_journal is None else core_journal.journal,
            previous=None if core_journal is None else core_journal.previous,
            on_restored=None if core_journal is None else core_journal.report,
            allowlist=allowlist,
            warn=lambda text: self._terminal_writer.write(
                "stderr", f"WARNING: {terminal_text.one_line(text, MAX_LINE_LENGTH)}\n"
            ),
        )
        self._logged_levels = LOG_LEVELS[LOG_LEVELS.index(log_level) :]
        self._environ = {**environ, "ROS_MASTER_URI": uri}
        self._environ.pop("ROS_NAMESPACE", None)
        self._uri = uri
        self._rosout: Node | None = None
        self._rosout_thread: threading.Thread | None = None
        self._rosout_error: Error | None = None
        self._warn_rosout: Callable[[str], object] = lambda text: None
        self._ending = threading.Event()

    def start_master(self) -> None:
        """Start the master.

        Raises:
            LaunchError: the port is in use, or cannot be used.
        """
        try:
            self._master.start()
        except OSError as error:
            self._master.stop(keep_journal=True)
            self._log.close()
            reason = error.strerror or str(error)
            if error.errno == errno.EADDRINUSE:
                reason = "the port is in use, by another master or by a program that is not a ROS master"
            raise LaunchError(f"cannot start a master at {self._uri}: {reason}") from error
        self._log_writer.write("", "")  # creates the file, even if nothing is logged

    def start_rosout(self, warn: Callable[[str], object] = lambda text: None) -> None:
        """Start the rosout node in a thread, so that the launch does not wait for the node's imports.

        If the node is shut down by another program, such as ``rosnode kill``, it is restarted.

        Args:
            warn: called in another thread with lines for the user when the node is restarted.
        """
        self._warn_rosout = warn
        self._rosout_thread = threading.Thread(target=self._start_rosout, name="start rosout", daemon=True)
        self._rosout_thread.start()

    def await_rosout(self) -> None:
        """Wait until the rosout node is running.

        Raises:
            Error: the node could not be started.
        """
        if self._rosout_thread is not None:
            self._rosout_thread.join()
            self._rosout_thread = None
        if self._rosout_error is not None:
            raise self._rosout_error

    def _start_rosout(self) -> None:
        try:
            self._make_rosout()
        except Error as error:
            self._rosout_error = error

    def _make_rosout(self) -> None:
        from pyros1.node.log.rosout import RosoutAggregator  # noqa: PLC0415 - only if no master runs yet
        from pyros1.node.node import Node  # noqa: PLC0415 - only if no master runs yet

        log = str(self._log_folder / "rosout.log")
        arguments = [f"__log:={self._log_folder / 'rosout-1.log'}"]
        self._rosout = node = Node(
            "rosout",
            namespace="/",
            argv=arguments,
            master_uri=self._uri,
            environ=self._environ,
            handle_signals=False,
            rosout=False,
            wait_for_master=10.0,
        )
        RosoutAggregator(node, log)
        node.on_shutdown(lambda: self._on_rosout_shutdown(node))

    def _on_rosout_shutdown(self, node: Node) -> None:
        if not self._ending.is_set():
            self._rosout_thread = threading.Thread(
                target=self._restart_rosout, args=(node,), name="restart rosout", daemon=True
            )
            self._rosout_thread.start()

    def _restart_rosout(self, node: Node) -> None:
        node.shutdown()  # waits until the node has shut down
        self._warn_rosout("[rosout-1] process has finished cleanly")
        if self._ending.wait(RESTART_DELAY_S):
            return
        self._warn_rosout("[rosout-1] restarting process")
        try:
            self._make_rosout()
        except Error as error:
            self._warn_rosout(f"[rosout-1] cannot be started again: {error}")
        else:
            self._warn_rosout(f"process[rosout-1]: started with pid [{os.getpid()}]")

    def stop_rosout(self) -> None:
        """Shut down the rosout node."""
        self._ending.set()
        if self._rosout_thread is not None:
            self._rosout_thread.join()
        if self._rosout is not None:
            self._rosout.shutdown("the core is shutting down")
            self._rosout = None

    def stop_master(self, *, keep_journal: bool = False) -> None:
        """Stop the master. With ``keep_journal``, keep its journal, so that the next master can restore the state."""
        self._master.stop(keep_journal=keep_journal)
        self._terminal_writer.close()
        self._log_writer.close()
        self._log.close()

    def _write_log(self, level: str, text: str) -> None:
        if level not in self._logged_levels:
            return
        now = time.time()
        stamp = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(now))
        millis = int(now * 1000) % 1000
        entry = terminal_text.one_line(text, MAX_LINE_LENGTH)
        self._log_writer.write("", f"[rosmaster.master][{level.upper()}] {stamp},{millis:03d}: {entry}\n")

    def _write_items(self, items: list[Item], _should_stop: ShouldStop) -> None:
        self._log.write("".join(text for _, text in items))


def write_pid_file(environ: Mapping[str, str], port: int, home: Path) -> None:
    """Write ``$ROS_HOME/roscore-<port>.pid`` (L17). Errors are ignored."""
    try:
        home.mkdir(parents=True, exist_ok=True)
        (home / f"roscore-{port}.pid").write_text(str(os.getpid()), encoding="ascii")
    except OSError:
        pass
