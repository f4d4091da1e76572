"""The master's journal, from which a new master restores the state of a master that was killed.

The file starts with a record that identifies the master, followed by the state at the time when the file was created
and one record per change. A record is a call to the Master API as XML-RPC, preceded by its length and checksum. When
the file has grown too much, it is replaced with a new one that holds the current state, so its size is bounded.

A separate thread writes the file, so the loop never waits for a disk. Records are written immediately: a master that is
killed loses at most the changes of its last tens of milliseconds. There is no fsync, since it would only matter after a
power cut; then the nodes on this machine are gone as well, and the journal is not used.
"""

from __future__ import annotations

import contextlib
import os
import queue
import stat
import struct
import threading
import zlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pyros1.ground.errors import Error
from pyros1.wire.xmlrpc import dumps_call, loads_call

MAGIC: Final = b"#PYROS1 MASTER JOURNAL 1\n"
MAX_SIZE: Final = 256 << 20
"""Maximum size in bytes of a journal to be read."""
HEARTBEAT_S: Final = 5.0
"""Seconds between two heartbeats, which update the file's modification time."""
MAX_PENDING: Final = 64 << 20
"""Maximum number of bytes that wait to be written. Beyond that, changes are dropped, and the file is rewritten
later."""
_RECORD_HEAD: Final = struct.Struct("<II")
_NO_FOLLOW: Final = getattr(os, "O_NOFOLLOW", 0)
_MIN_GROWTH: Final = 1 << 20  # the file is rewritten when it has grown by this many bytes and to twice its initial size

Call = tuple[str, Sequence[Any]]
"""A method of the Master API, and its arguments."""


class JournalError(Error):
    """A journal cannot be used."""


@dataclass(frozen=True)
class JournalContents:
    """The contents of the previous master's journal.

    Attributes:
        calls: the calls that reproduce the state, in order.
        pid: the process id of the previous master.
        boot: the id of the machine's boot during which that master ran; see `boot_id`.
        last_alive_at: the time of its last heartbeat, in seconds since the epoch.
        truncated: whether the end of the file is missing or damaged; the preceding records are valid.
    """

    calls: tuple[Call, ...]
    pid: int
    boot: str
    last_alive_at: float
    truncated: bool


def boot_id() -> str:
    """Return an identifier of this machine's current boot; empty if the system has none."""
    with contextlib.suppress(OSError):
        return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    return ""


def encode_record(call: Call) -> bytes:
    """Return a call encoded as a record."""
    body = dumps_call(*call)
    return _RECORD_HEAD.pack(len(body), zlib.crc32(body)) + body


def decode_records(data: bytes) -> Iterator[Call | None]:
    """Yield the calls in records; at the end, yield None if the remaining data are incomplete or damaged."""
    position = 0
    while position < len(data):
        if position + _RECORD_HEAD.size > len(data):
            yield None
            return
        size, checksum = _RECORD_HEAD.unpack_from(data, position)
        position += _RECORD_HEAD.size
        body = data[position : position + size]
        if len(body) < size or zlib.crc32(body) != checksum:
            yield None
            return
        try:
            yield loads_call(body)
        except Error:
            yield None
            return
        position += size


def read_journal(path: Path) -> JournalContents | None:
    """Read the journal of a master that did not shut down normally.

    Returns:
        The contents; None if there is no journal.

    Raises:
        JournalError: the file is not a journal, belongs to another user, or cannot be read.
    """
    try:
        # O_NONBLOCK is used because opening a pipe would block.
        descriptor = os.open(path, os.O_RDONLY | _NO_FOLLOW | getattr(os, "O_NONBLOCK", 0))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise JournalError(f"{path} cannot be read: {error.strerror}") from error
    file_status = os.fstat(descriptor)
    if not stat.S_ISREG(file_status.st_mode):
        os.close(descriptor)
        raise JournalError(f"{path} is not a file")
    with open(descriptor, "rb") as file:
        if hasattr(os, "getuid") and file_status.st_uid != os.getuid():
            raise JournalError(f"{path} belongs to another user")
        if file_status.st_size > MAX_SIZE:
            raise JournalError(f"{path} is larger than {MAX_SIZE >> 20} MiB")
        data = file.read(MAX_SIZE)
    if not data.startswith(MAGIC):
        raise JournalError(f"{path} is not the journal of a master")
    calls = list(decode_records(data[len(MAGIC) :]))
    is_truncated = bool(calls) and calls[-1] is None
    valid_calls = [call for call in calls if call is not None]
    first_call = valid_calls[0] if valid_calls else ("", ())
    if first_call[0] != "begin" or [type(item) for item in first_call[1]] != [int, str]:
        raise JournalError(f"{path} does not say which master it belongs to")
    pid, boot = first_call[1]
    return JournalContents(tuple(valid_calls[1:]), pid, boot, file_status.st_mtime, is_truncated)


class Journal:
    """Writes a journal. All methods except `close` are called on the master's loop.

    Args:
        path: the file; its folder is created. A lock file in the same folder is locked until `close`.
        on_problem: called with a message, in another thread, when the file cannot be written; not called again until
            the file has been written successfully.

    Raises:
        JournalError: the folder cannot be used, or another master uses the file.
    """

    def __init__(self, path: Path, on_problem: Callable[[str], object]) -> None:
        self._path = path
        self._on_problem = on_problem
        self._lock_descriptor = _lock_file(path.with_suffix(".lock"))
        self._actions: queue.SimpleQueue[tuple[str, bytes]] = queue.SimpleQueue()
        self._lookahead: tuple[str, bytes] | None = None  # taken from the queue, to be processed next
        self._queued_bytes = 0  # total so far; changed only by the loop
        self._written_bytes = 0  # total so far; changed only by the writer thread
        self._initial_size = self._added_size = 0  # bytes of the initial state and of the changes in the file
        self._is_broken = False
        self._has_gap = False  # whether a change was dropped, so that later changes must not be written
        self._descriptor = -1
        self._thread = threading.Thread(target=self._run, name="master: journal", daemon=True)
        self._thread.start()

    @property
    def has_grown(self) -> bool:
        """Whether the file has grown so much that it should be rewritten with `rewrite`."""
        return not self._is_broken and self._added_size > max(_MIN_GROWTH, self._initial_size)

    @property
    def needs_rewrite(self) -> bool:
        """Whether the file should be rewritten at the next opportunity: it has grown, or could not be written.

        In the latter case, this is False until the writer has caught up, since `rewrite` queues the entire state.
        """
        return self.has_grown or (self._is_broken and self._queued_bytes == self._written_bytes)

    def rewrite(self, calls: Iterable[Call]) -> None:
        """Replace the file with one that contains only the given calls, which reproduce the current state."""
        data = MAGIC + encode_record(("begin", (os.getpid(), boot_id()))) + b"".join(map(encode_record, calls))
        self._is_broken = self._has_gap = False
        self._initial_size, self._added_size = len(data), 0
        self._enqueue("replace", data)

    def add(self, call: Call) -> None:
        """Append a call that has changed the state."""
        data = encode_record(call)
        self._added_size += len(data)
        self._enqueue("add", data)

    def heartbeat(self) -> None:
        """Record that the master is alive. Call this every `HEARTBEAT_S` seconds."""
        self._enqueue("tick", b"")

    def close(self, *, remove: bool = True, timeout: float = 2.0) -> None:
        """Stop writing; no effect if already closed.

        Args:
            remove: whether to remove the file, because the master shuts down normally and should not be restored.
            timeout: maximum number of seconds to wait for the disk. After that, the lock is kept until this process
                exits: the pending writes must not damage the file of the next master.
        """
        if self._lock_descriptor < 0:
            return
        self._actions.put(("remove" if remove else "end", b""))
        self._thread.join(timeout)
        if not self._thread.is_alive():
            os.close(self._lock_descriptor)
            self._lock_descriptor = -1

    def _enqueue(self, action: str, data: bytes) -> None:
        is_full = self._queued_bytes - self._written_bytes + len(data) > MAX_PENDING
        if action != "replace" and (is_full or self._has_gap):
            self._is_broken = self._has_gap = True
            return
        self._queued_bytes += len(data)
        self._actions.put((action, data))

    def _run(self) -> None:
        has_warned = False
        while True:
            action, data = self._next_action()
            try:
                if action == "replace":
                    self._replace(data)
                    has_warned = False
                elif action == "add" and self._descriptor >= 0:
                    _write(self._descriptor, data)
                elif action == "tick" and self._descriptor >= 0:
                    os.utime(self._path)
                elif action == "remove":
                    self._path.unlink(missing_ok=True)
            except OSError as error:
                self._discard_file()
                if not has_warned:
                    has_warned = True
                    self._on_problem(f"the journal {self._path} cannot be written: {error.strerror}")
            self._written_bytes += len(data)
            if action in ("remove", "end"):
                self._close_file()
                return

    def _next_action(self) -> tuple[str, bytes]:
        """Return the next action and its data. Consecutive additions are joined to make fewer writes."""
        if self._lookahead is not None:
            action, data = self._lookahead
            self._lookahead = None
        else:
            action, data = self._actions.get()
        parts = [data]
        while action == "add":
            try:
                self._lookahead = self._actions.get_nowait()
            except queue.Empty:
                break
            if self._lookahead[0] != "add":
                break
            parts.append(self._lookahead[1])
            self._lookahead = None
        return action, b"".join(parts)

    def _replace(self, data: bytes) -> None:
        new_path = self._path.with_suffix(".new")
        new_path.unlink(missing_ok=True)
        self._close_file()
        self._descriptor = os.open(new_path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND, 0o600)
        _write(self._descriptor, data)
        os.replace(new_path, self._path)

    def _discard_file(self) -> None:
        """Remove the incomplete file; `needs_rewrite` then requests a new one."""
        self._close_file()
        for path in (self._path, self._path.with_suffix(".new")):
            with contextlib.suppress(OSError):
                path.unlink()
        self._is_broken = True

    def _close_file(self) -> None:
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


def _write(descriptor: int, data: bytes) -> None:
    remaining = memoryview(data)
    while remaining:
        remaining = remaining[os.write(descriptor, remaining) :]


def _lock_file(path: Path) -> int:
    """Lock a file and return its descriptor.

    Raises:
        JournalError: the file cannot be created, or another process has locked it.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | _NO_FOLLOW, 0o600)
    except OSError as error:
        raise JournalError(f"{path} cannot be created: {error.strerror}") from error
    try:
        import fcntl  # noqa: PLC0415 - Unix only

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except ImportError:
        pass
    except OSError as error:
        os.close(descriptor)
        raise JournalError(f"another master is using {path.with_suffix('.journal')}") from error
    return descriptor
