"""The journal of a core, from which the next core restores the state if this one is killed."""

from __future__ import annotations

import os
import re
import socket
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pyros1.launch.running.logs import ros_home

if TYPE_CHECKING:
    from pyros1.launch.running.console import Console
    from pyros1.master.journal import Journal, JournalContents


class CoreJournal:
    """The journal of a core, and the state restored from the previous core's journal.

    Args:
        environ: environment variables; ROS_HOME is used.
        port: port of the master. Each host, port and user has a separate journal.
        console: prints what is restored or why nothing is.

    Attributes:
        journal: the journal of this core; None if there is none.
        previous: the content of the previous core's journal; None if nothing is restored.
    """

    def __init__(self, environ: Mapping[str, str], port: int, console: Console) -> None:
        from pyros1.master.journal import Journal, JournalError, read_journal  # noqa: PLC0415 - only for a core
        from pyros1.master.recovery import any_reachable, stale_reason  # noqa: PLC0415 - as above

        self._console = console
        self.journal: Journal | None = None
        self.previous: JournalContents | None = None
        path = _journal_path(environ, port)
        try:
            self.journal = Journal(path, console.warning)
        except JournalError as error:
            console.warning(f"this master has no journal, so its state cannot be restored after a restart: {error}")
            return
        try:
            self.previous = read_journal(path)
        except JournalError as error:
            _set_aside(path, str(error), console)
        if self.previous is None:
            return
        reason = stale_reason(self.previous, time.time(), any_reachable)
        if reason:
            _set_aside(path, f"its state is not restored: {reason}", console)
            self.previous = None
        else:
            truncated = ", except for its last changes, which were not written" if self.previous.truncated else ""
            console.line(f"restoring the state of the master that was killed (pid {self.previous.pid}){truncated}")

    @property
    def previous_run_id(self) -> str | None:
        """The run id of the previous core; None if it is unknown."""
        value: Any = None
        for method, params in self.previous.calls if self.previous is not None else ():
            if method == "setParam" and len(params) == 3:
                key, new_value = params[1:]
                if key == "/run_id":
                    value = new_value
                elif key == "/" and isinstance(new_value, dict):
                    value = new_value.get("run_id")
        return value if isinstance(value, str) else None

    def report(self, num_reachable: int, unreachable: list[str]) -> None:
        """Print how many nodes of the previous core still run, and which do not. Called in the master's thread.

        Args:
            num_reachable: number of running nodes.
            unreachable: names of the other nodes.
        """
        # /rosout was part of the previous core, and this core has its own.
        unreachable = [name for name in unreachable if name != "/rosout"]
        if not num_reachable and not unreachable:
            return  # the journal had only parameters, no nodes
        text = f"resumed with {num_reachable} {'node' if num_reachable == 1 else 'nodes'} from the previous master"
        if unreachable:
            text += f"; no longer running: {', '.join(unreachable[:20])}{' ...' if len(unreachable) > 20 else ''}"
        self._console.line(text)

    def release(self) -> None:
        """Close the journal and keep its file for the next core, since this core could not be started."""
        if self.journal is not None:
            self.journal.close(remove=False)
            self.journal = None


def set_aside_journal(environ: Mapping[str, str], port: int, console: Console) -> None:
    """Rename the journal of the previous core: a master without a journal is running, so the saved state is outdated.

    Args:
        environ, port, console: see `CoreJournal`.
    """
    path = _journal_path(environ, port)
    if not path.exists():
        return
    from pyros1.master.journal import Journal, JournalError  # noqa: PLC0415 - rarely needed

    try:
        journal = Journal(path, console.warning)
    except JournalError:
        return  # another master is using it
    _set_aside(path, "its state is not restored, as this master has no journal", console)
    journal.close(remove=False)


def _journal_path(environ: Mapping[str, str], port: int) -> Path:
    host = re.sub(r"[^A-Za-z0-9._-]", "_", socket.gethostname())[:100]
    return Path(ros_home(environ), "pyros1", f"master-{host}-{port}.journal")


def _set_aside(path: Path, reason: str, console: Console) -> None:
    old_path = path.with_suffix(".old")
    try:
        os.replace(path, old_path)
    except OSError as error:
        console.warning(f"the journal of a previous master, {path}: {reason} ({error.strerror})")
        return
    console.warning(f"the journal of a previous master, now {old_path}: {reason}")
