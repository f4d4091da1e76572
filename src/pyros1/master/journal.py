"""The master's journal: what a new master needs to continue where a killed one stopped.

A file with one record per change, after a first record that says whose it is and the state when the file was created. A
record is a call of the Master API as XML-RPC, with its length and checksum before it. When much has been added, a new
file with the present state takes the old one's place (written aside, renamed), so its size is bounded.

A separate thread writes; the loop never waits for a disk. Records are handed to the system at once: a master that is
killed loses the changes of at most its last tens of milliseconds. Nothing is ever synced: that is for power cuts, and
after one the nodes of this machine are gone as well, so that the file is not used.
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
"""Bytes of the largest journal that is read."""
HEARTBEAT_S: Final = 5.0
"""Seconds between two signs of life, the file's time of change."""
MAX_PENDING: Final = 64 << 20
"""Bytes that wait for a disk; if any are lost, the file is rewritten."""
_FRAME: Final = struct.Struct("<II")
_NO_LINK: Final = getattr(os, "O_NOFOLLOW", 0)
_GROWTH: Final = 1 << 20  # bytes that may be added, or as many as the state has, before the file is rewritten

Call = tuple[str, Sequence[Any]]
"""Method of the Master API, and its arguments."""


class JournalError(Error):
    """A journal cannot be used."""


@dataclass(frozen=True)
class JournalContents:
    """Content of the journal of an earlier master.

    Attributes:
        calls: to be made on the new master, in order.
        pid: of the earlier master.
        boot: identifies the start of the machine; see `boot_id`.
        last_alive: seconds since the epoch when it gave its last sign of life.
        truncated: whether the end of the file is missing or damaged; what comes before is good.
    """

    calls: tuple[Call, ...]
    pid: int
    boot: str
    last_alive: float
    truncated: bool


def boot_id() -> str:
    """Return an identifier of the current start of this machine; empty if the system has none."""
    with contextlib.suppress(OSError):
        return Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    return ""


def encode_record(call: Call) -> bytes:
    """Return a call as a record."""
    body = dumps_call(*call)
    return _FRAME.pack(len(body), zlib.crc32(body)) + body


def decode_records(data: bytes) -> Iterator[Call | None]:
    """Yield the calls of records; None at the end if the rest is missing or damaged."""
    position = 0
    while position < len(data):
        if position + _FRAME.size > len(data):
            yield None
            return
        size, checksum = _FRAME.unpack_from(data, position)
        position += _FRAME.size
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


def read(path: Path) -> JournalContents | None:
    """Read the journal of a master that did not end normally.

    Returns:
        Its content; None if there is none.

    Raises:
        JournalError: the file is no journal, not this user's, or cannot be read.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | _NO_LINK | getattr(os, "O_NONBLOCK", 0))  # a pipe would wait
    except FileNotFoundError:
        return None
    except OSError as error:
        raise JournalError(f"{path} cannot be read: {error.strerror}") from error
    facts = os.fstat(descriptor)
    if not stat.S_ISREG(facts.st_mode):
        os.close(descriptor)
        raise JournalError(f"{path} is not a file")
    with open(descriptor, "rb") as file:
        if hasattr(os, "getuid") and facts.st_uid != os.getuid():
            raise JournalError(f"{path} belongs to another user")
        if facts.st_size > MAX_SIZE:
            raise JournalError(f"{path} has more than {MAX_SIZE >> 20} MiB")
        data = file.read(MAX_SIZE)
    if not data.startswith(MAGIC):
        raise JournalError(f"{path} is not the journal of a master")
    calls = list(decode_records(data[len(MAGIC) :]))
    truncated = bool(calls) and calls[-1] is None
    known = [call for call in calls if call is not None]
    first = known[0] if known else ("", ())
    if first[0] != "begin" or [type(item) for item in first[1]] != [int, str]:
        raise JournalError(f"{path} does not say which master it belongs to")
    pid, boot = first[1]
    return JournalContents(tuple(known[1:]), pid, boot, facts.st_mtime, truncated)


class Journal:
    """Writer of a journal. All but `close` is called on the master's loop.

    Args:
        path: the file; its folder is created. A file beside it is locked while this object lives.
        on_problem: called with a text, in another thread, when the file cannot be written; once until it can again.

    Raises:
        JournalError: the folder cannot be used, or another master uses the file.
    """

    def __init__(self, path: Path, on_problem: Callable[[str], object]) -> None:
        self._path = path
        self._on_problem = on_problem
        self._lock = _lock_file(path.with_suffix(".lock"))
        self._work: queue.SimpleQueue[tuple[str, bytes]] = queue.SimpleQueue()
        self._lookahead: tuple[str, bytes] | None = None  # already off the queue, for the next turn of the writer
        self._queued_bytes = 0  # bytes; only the loop adds, only the writer subtracts
        self._written_bytes = 0
        self._base = self._added = 0  # sizes of the state at the beginning, and of what was added
        self._broken = False
        self._has_gap = False  # a change was left out: no later one may follow it
        self._descriptor = -1
        self._thread = threading.Thread(target=self._run, name="master: journal", daemon=True)
        self._thread.start()

    @property
    def has_grown(self) -> bool:
        """Whether the file should be rewritten, by `begin`, as it has grown."""
        return not self._broken and self._added > max(_GROWTH, self._base)

    @property
    def needs_rewrite(self) -> bool:
        """Whether the file should be rewritten when there is time: it has grown, or could not be written.

        Not while the writer still has work: each beginning holds the whole state.
        """
        return self.has_grown or (self._broken and self._queued_bytes == self._written_bytes)

    def begin(self, calls: Iterable[Call]) -> None:
        """Rewrite the file with a state."""
        data = MAGIC + encode_record(("begin", (os.getpid(), boot_id()))) + b"".join(map(encode_record, calls))
        self._broken = self._has_gap = False
        self._base, self._added = len(data), 0
        self._put("begin", data)

    def add(self, call: Call) -> None:
        """Add a change."""
        data = encode_record(call)
        self._added += len(data)
        self._put("add", data)

    def heartbeat(self) -> None:
        """Give a sign of life; call it every `HEARTBEAT_S` seconds."""
        self._put("tick", b"")

    def close(self, *, remove: bool = True, timeout: float = 2.0) -> None:
        """End the writing; harmless if done before.

        Args:
            remove: the master ends normally: no other is to continue it.
            timeout: maximum seconds to wait for the disk. If that is not enough, the lock ends with this process, as
                what is still written then would damage the next master's file.
        """
        if self._lock < 0:
            return
        self._work.put(("remove" if remove else "end", b""))
        self._thread.join(timeout)
        if not self._thread.is_alive():
            os.close(self._lock)
            self._lock = -1

    def _put(self, what: str, data: bytes) -> None:
        full = self._queued_bytes - self._written_bytes + len(data) > MAX_PENDING
        if what != "begin" and (full or self._has_gap):
            self._broken = self._has_gap = True
            return
        self._queued_bytes += len(data)
        self._work.put((what, data))

    def _run(self) -> None:
        warned = False
        while True:
            what, data = self._next()
            try:
                if what == "begin":
                    self._replace(data)
                    warned = False
                elif what == "add" and self._descriptor >= 0:
                    _write(self._descriptor, data)
                elif what == "tick" and self._descriptor >= 0:
                    os.utime(self._path)
                elif what == "remove":
                    self._path.unlink(missing_ok=True)
            except OSError as error:
                self._give_up()
                if not warned:
                    warned = True
                    self._on_problem(f"the journal {self._path} cannot be written: {error.strerror}")
            self._written_bytes += len(data)
            if what in ("remove", "end"):
                self._drop()
                return

    def _next(self) -> tuple[str, bytes]:
        """Return the next piece of work, additions joined: while the loop is busy, each write costs a wait for it."""
        if self._lookahead is not None:
            what, data = self._lookahead
            self._lookahead = None
        else:
            what, data = self._work.get()
        joined = [data]
        while what == "add":
            try:
                self._lookahead = self._work.get_nowait()
            except queue.Empty:
                break
            if self._lookahead[0] != "add":
                break
            joined.append(self._lookahead[1])
            self._lookahead = None
        return what, b"".join(joined)

    def _replace(self, data: bytes) -> None:
        new_path = self._path.with_suffix(".new")
        new_path.unlink(missing_ok=True)
        self._drop()
        self._descriptor = os.open(new_path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND, 0o600)
        _write(self._descriptor, data)
        os.replace(new_path, self._path)

    def _give_up(self) -> None:
        """Remove what is no longer the whole truth; `needs_rewrite` asks for a new beginning."""
        self._drop()
        for path in (self._path, self._path.with_suffix(".new")):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
        self._broken = True

    def _drop(self) -> None:
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


def _write(descriptor: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(descriptor, view) :]


def _lock_file(path: Path) -> int:
    """Return the descriptor of a lock file that no other process holds."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | _NO_LINK, 0o600)
    except OSError as error:
        raise JournalError(f"{path} cannot be created: {error.strerror}") from error
    try:
        import fcntl  # noqa: PLC0415 - Unix only

        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except ImportError:
        pass
    except OSError as error:
        os.close(descriptor)
        raise JournalError(f"another master uses {path.with_suffix('.journal')}") from error
    return descriptor
