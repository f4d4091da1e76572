"""The master's journal: whenever the master is killed, it gives a state that was, and none older than read before."""

from __future__ import annotations

import errno
import os
import tempfile
from itertools import count
from pathlib import Path
from typing import Any

from pyros1.master.journal import Journal, JournalContents, read_journal
from pyros1.master.server import Master
from pyros1.net.master_client import MasterClient

from ..stage import Scenario, Stage

THREADS, CHANGES = 2, 4


class Journalling(Scenario):
    """Threads set parameters; the journal is begun anew again and again, and read at any moment."""

    modules = ("pyros1.master.journal", "pyros1.master.server")
    limits: tuple[tuple[str, str, Any], ...] = (
        ("pyros1.master.journal", "_MIN_GROWTH", 200),
        ("pyros1.master.server", "HEARTBEAT_S", 1e-3),
        ("pyros1.master.server", "SPIN_TIME", 0.0),
    )
    vanishes = False

    def play(self, stage: Stage) -> None:
        """Play it."""
        with tempfile.TemporaryDirectory() as folder:
            self.act(stage, Path(folder) / "master.journal")

    def act(self, stage: Stage, path: Path) -> None:
        """Play it, with a journal there."""
        names: list[str] = []  # of the parameters, in the order in which they were set
        over: list[bool] = []

        def log(_level: str, text: str) -> None:
            if text.startswith("+PARAM ["):
                names.append(text[text.index("[") + 1 : text.index("]")])

        journal = Journal(path, lambda text: None)
        master = Master(port=0, bind_host="127.0.0.1", journal=journal, log=log)
        master.start()

        def setter(thread: int) -> Any:
            def set_them() -> None:
                client = MasterClient(f"/setter{thread}", master.uri)
                for number in range(CHANGES):
                    client.set_param(f"/p{thread}_{number}", number)
                client.close()

            return set_them

        def look() -> None:
            last = -1
            while not over:
                previous = read_journal(path)
                if previous is None:
                    assert last < 0 or self.vanishes, "there was one before"
                else:
                    now = set_by(previous)
                    assert now == set(names[: len(now)]), f"{now} never was: {names}"
                    assert len(now) >= last, "an earlier state than before"
                    last = len(now)
                stage.time.sleep(20e-6)

        looking = stage.spawn(look)
        stage.together(*(setter(thread) for thread in range(THREADS)))
        end = stage.time.monotonic() + 10.0
        while (previous := read_journal(path)) is None or set_by(previous) != set(names):
            assert stage.time.monotonic() < end, "the last changes are missing"
            stage.time.sleep(1e-3)
        over.append(True)
        looking[0].join()
        journal.close(remove=False)  # nothing is done any more, as after a kill
        master.stop()
        following = Master(port=0, bind_host="127.0.0.1", previous=read_journal(path) or previous)
        following.start()
        client = MasterClient("/asker", following.uri)
        assert set(client.get_param_names()) == set(names)
        client.close()
        following.stop()


class JournallingFull(Journalling):
    """The same on a disk that is full now and then: there is no journal, or one with a state that was."""

    vanishes = True

    def __init__(self) -> None:
        super().__init__()
        self.limits = (*self.limits, ("pyros1.master.journal", "_write", self.write))
        self._turns = count()

    def play(self, stage: Stage) -> None:
        """Play it."""
        self._turns = count()
        super().play(stage)

    def write(self, descriptor: int, data: bytes) -> None:
        """Write all, or a part."""
        full = next(self._turns) % 3 == 2
        os.write(descriptor, data[: len(data) // 2] if full else data)
        if full:
            raise OSError(errno.ENOSPC, "No space left on device")


def set_by(previous: JournalContents) -> set[str]:
    """Return the names of the parameters in a journal."""
    names: set[str] = set()
    for method, params in previous.calls:
        if method == "setParam":
            _, key, value = params
            names |= {f"/{name}" for name in value} if key == "/" else {key}
    return names
