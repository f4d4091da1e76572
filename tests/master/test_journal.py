"""master.journal and master.recovery: what a new master gets from one that was killed.

Feature: a core that is killed and started again carries on
"""

from __future__ import annotations

import datetime
import errno
import os
import random
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.ground.errors import UnreachableError, XmlRpcFault
from pyros1.master import journal as journals
from pyros1.master.api import METHODS, MasterApi
from pyros1.master.journal import MAGIC, Journal, JournalContents, JournalError, boot_id, encode_record, read_journal
from pyros1.master.recovery import Recovery, any_reachable, stale_reason
from pyros1.master.registry import RegisteredNode
from pyros1.master.server import Master
from pyros1.net.loop import Loop
from pyros1.net.master_client import MasterClient
from pyros1.net.rpc_caller import RpcCaller

Log = Callable[[str], object]


def make_api(record: Any = None) -> MasterApi:
    return MasterApi(notify=lambda _: None, log=lambda *_: None, on_shutdown=lambda _: None, pid=1, record=record)


def random_call(chance: random.Random) -> tuple[str, list[Any]]:
    """A call that may change the master; some do not, or are refused."""
    node = chance.choice(["/a", "/b", "/c/d"])
    api = f"http://host:{chance.choice([1, 2])}/"
    topic = chance.choice(["/t", "u", "~v", "/w/x"])
    kind = chance.choice(["*", "std_msgs/String", "std_msgs/Int32"])
    key = chance.choice(["/p", "/p/q", "r", "~s", "/", "/p/q/t"])
    value = chance.choice([1, 2.5, "text", True, [1, [2]], {"a": {"b": 1}}, {}, b"\0\xff", "é\n<&", {"": 1}])
    return chance.choice(
        [
            ("registerPublisher", [node, topic, kind, api]),
            ("registerSubscriber", [node, topic, kind, api]),
            ("unregisterPublisher", [node, topic, api]),
            ("unregisterSubscriber", [node, topic, api]),
            ("registerService", [node, topic, f"rosrpc://host:{chance.choice([1, 2])}", api]),
            ("unregisterService", [node, topic, f"rosrpc://host:{chance.choice([1, 2])}"]),
            ("setParam", [node, key, value]),
            ("deleteParam", [node, key]),
            ("subscribeParam", [node, api, key]),
            ("unsubscribeParam", [node, api, key]),
            ("registerPublisher", [node, "", kind, api]),
            ("getSystemState", [node]),
        ]
    )


def state(api: MasterApi) -> Any:
    """All that one can ask. A node whose only service was taken over by another is not known any more."""
    registry = api.registry
    nodes = {name for part in registry.system_state() for _, names in part for name in names}
    nodes |= {name for names in registry.param_subscribers.values() for name in names}
    services = [name for name, _ in registry.system_state()[2]]
    return (
        registry.system_state(),
        registry.topic_types(),
        {name: registry.service_uri(name) for name in services},
        {name: registry.node_api(name) for name in nodes},
        registry.param_subscribers,
        api.parameters.get("/"),
        [registry.publisher_apis(topic) for topic, _ in registry.system_state()[0]],
    )


@pytest.mark.parametrize("seed", range(40))
def test_a_journal_gives_the_state_back_wherever_it_was_cut(seed: int) -> None:
    chance = random.Random(seed)
    records: list[Any] = []
    api = make_api(lambda method, params: records.append((method, params)))
    for _ in range(chance.randrange(30)):
        api.dispatch(*random_call(chance))
    data = b"".join(map(encode_record, api.snapshot()))
    states, ends = [state(restored(data))], [len(data)]
    assert states[0] == state(api)
    records.clear()
    for _ in range(chance.randrange(1, 30)):
        before = len(records)
        api.dispatch(*random_call(chance))
        for record in records[before:]:
            data += encode_record(record)
            ends.append(len(data))
            states.append(state(restored(data)))
    assert states[-1] == state(api)
    for _ in range(10):
        truncated = chance.randrange(ends[0], len(data) + 1)
        whole = max(index for index, end in enumerate(ends) if end <= truncated)
        assert state(restored(data[:truncated])) == states[whole]


def restored(data: bytes) -> MasterApi:
    api = make_api()
    api.restore(call for call in journals.decode_records(data) if call is not None)
    return api


@pytest.mark.parametrize("seed", range(100))
def test_spoilt_bytes_end_what_is_read(seed: int) -> None:
    chance = random.Random(seed)
    calls = [("setParam", ["/a", f"/key{number}", number]) for number in range(10)]
    data = bytearray(b"".join(map(encode_record, calls)))
    for _ in range(chance.randrange(1, 4)):
        data[chance.randrange(len(data))] = chance.randrange(256)
    previous = list(journals.decode_records(bytes(data)))
    good = [call for call in previous if call is not None]
    assert [list(call) for call in good] == [[name, params] for name, params in calls[: len(good)]]
    make_api().restore(good)


def test_restoring_takes_what_it_can() -> None:
    api = make_api()
    api.restore(
        [
            ("topicTypes", [[["/t", "a/B"], ["/u"], 3, ["/v", 4]]]),
            ("topicTypes", []),
            ("shutdown", ["/a", "x"]),
            ("nothing", [1]),
            ("setParam", ["/a"]),
            ("setParam", ["/a", "/p", 1]),
        ]
    )
    assert api.registry.topic_types() == []
    assert api.parameters.get("/") == {"p": 1}


@pytest.fixture
def journal(tmp_path: Path) -> Iterator[Callable[..., Journal]]:
    """Return a function that makes journals; what is left open is closed."""
    made: list[Journal] = []

    def make(path: Path = tmp_path / "own" / "m.journal", log: Log = print) -> Journal:
        made.append(Journal(path, log))
        return made[-1]

    yield make
    for each in made:
        each.close()


def test_what_was_written_is_read(journal: Callable[..., Journal], tmp_path: Path) -> None:
    path = tmp_path / "own" / "m.journal"
    writer = journal()
    writer.rewrite([("setParam", ["/a", "/", {"x": 1}])])
    writer.add(("setParam", ["/a", "/y", [1, 2]]))
    writer.heartbeat()
    writer.close(remove=False)
    previous = read_journal(path)
    assert previous is not None
    assert [list(call) for call in previous.calls] == [
        ["setParam", ["/a", "/", {"x": 1}]],
        ["setParam", ["/a", "/y", [1, 2]]],
    ]
    assert (previous.pid, previous.boot, previous.truncated) == (os.getpid(), boot_id(), False)
    assert path.stat().st_mode & 0o777 == 0o600
    with path.open("ab") as file:
        file.write(b"\x10\0\0\0abc")
    assert read_journal(path).truncated  # type: ignore[union-attr]


def test_a_closed_journal_keeps_no_file_open(journal: Callable[..., Journal], tmp_path: Path) -> None:
    writer = journal()
    writer.rewrite([])
    writer.close(remove=False)
    open_files = [os.readlink(f"/proc/self/fd/{number}") for number in os.listdir("/proc/self/fd") if _exists(number)]
    assert not [file for file in open_files if file.startswith(str(tmp_path))]


def _exists(number: str) -> bool:
    return os.path.lexists(f"/proc/self/fd/{number}")


def test_an_orderly_end_leaves_nothing(journal: Callable[..., Journal], tmp_path: Path) -> None:
    writer = journal()
    writer.rewrite([])
    writer.close()
    assert read_journal(tmp_path / "own" / "m.journal") is None


def test_it_does_not_grow_for_ever(journal: Callable[..., Journal], tmp_path: Path) -> None:
    writer = journal()
    writer.rewrite([])
    added = 0
    while not writer.needs_rewrite:
        writer.add(("setParam", ["/a", "/x", "x" * 10_000]))
        added += 1
    assert 90 < added < 120
    writer.rewrite([("setParam", ["/a", "/", {"x": "x" * 10_000}])])
    assert not writer.needs_rewrite
    writer.close(remove=False)
    assert (tmp_path / "own" / "m.journal").stat().st_size < 11_000


@pytest.mark.parametrize("make", [Path.mkdir, os.mkfifo])
def test_what_is_no_file_is_no_journal(make: Callable[[Path], object], tmp_path: Path) -> None:
    make(tmp_path / "m.journal")
    with pytest.raises(JournalError, match="is not a file"):
        read_journal(tmp_path / "m.journal")


def test_one_journal_has_one_writer(journal: Callable[..., Journal]) -> None:
    first = journal()
    with pytest.raises(JournalError, match="another master is using"):
        journal()
    first.close()
    journal()


def test_a_writer_that_a_disk_holds_up_keeps_the_lock(
    journal: Callable[..., Journal], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What it still has to do, its file or the removal, would spoil the file of the next master."""
    leave, replace = threading.Event(), os.replace
    monkeypatch.setattr(os, "replace", lambda *paths: (leave.wait(10), replace(*paths)))
    first = journal()
    first.rewrite([])
    first.close(timeout=0.01)
    with pytest.raises(JournalError, match="another master is using"):
        journal()
    leave.set()
    first.close()
    journal()


def test_nothing_follows_a_change_that_was_left_out(
    journal: Callable[..., Journal], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when a disk is too slow: the file then has an earlier state, but none that never was."""
    monkeypatch.setattr(journals, "MAX_PENDING", 1000)
    writer = journal()
    writer.rewrite([])
    writer.add(("setParam", ["/a", "/large", "x" * 2000]))
    writer.add(("setParam", ["/a", "/small", 1]))
    writer.heartbeat()
    until = time.monotonic() + 10
    while not writer.needs_rewrite:
        assert time.monotonic() < until
    writer.close(remove=False)
    previous = read_journal(tmp_path / "own" / "m.journal")
    assert previous is not None and previous.calls == ()


def test_a_full_disk_is_told_once_and_asked_for_again(
    journal: Callable[..., Journal], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    came = threading.Event()
    writer = journal(log=lambda text: (told.append(text), came.set()))

    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", fail)
        writer.rewrite([])
        assert came.wait(10)
        until = time.monotonic() + 10
        while not writer.needs_rewrite:
            assert time.monotonic() < until
    writer.rewrite([("setParam", ["/a", "/x", 1])])
    writer.close(remove=False)
    assert len(told) == 1 and "No space left" in told[0]
    previous = read_journal(tmp_path / "own" / "m.journal")
    assert previous is not None and len(previous.calls) == 1


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "not the journal"),
        (b"hello", "not the journal"),
        (MAGIC, "which master"),
        (MAGIC + encode_record(("setParam", ["/a", "/b", 1])), "which master"),
        (MAGIC + encode_record(("begin", ["x", 1])), "which master"),
    ],
)
def test_what_is_no_journal(tmp_path: Path, content: bytes, why: str) -> None:
    path = tmp_path / "x.journal"
    path.write_bytes(content)
    with pytest.raises(JournalError, match=why):
        read_journal(path)
    path.unlink()
    path.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(JournalError, match="cannot be read"):
        read_journal(path)


def test_a_journal_of_somebody_else_or_without_end_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "x.journal"
    path.write_bytes(MAGIC + bytes(2 << 20))
    with monkeypatch.context() as patch:
        patch.setattr(journals, "MAX_SIZE", 1 << 20)
        with pytest.raises(JournalError, match="is larger than 1 MiB"):
            read_journal(path)
    if hasattr(os, "getuid"):
        monkeypatch.setattr(os, "getuid", lambda: path.stat().st_uid + 1)
        with pytest.raises(JournalError, match="belongs to another user"):
            read_journal(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_a_pipe_in_its_place_is_not_waited_for(tmp_path: Path) -> None:
    path = tmp_path / "m.journal"
    os.mkfifo(path)
    with pytest.raises(JournalError, match="is not a file"):
        read_journal(path)


def test_stale_journals() -> None:
    previous = JournalContents((("registerPublisher", ["/a", "/t", "*", "http://h:1/"]),), 1, boot_id(), 1000.0, False)
    assert stale_reason(previous, 1059.0, lambda _: False) == ""
    assert "none of its nodes is running" in stale_reason(previous, 1061.0, lambda apis: list(apis) != ["http://h:1/"])
    assert stale_reason(previous, 1061.0, lambda _: True) == ""
    assert "restarted" in stale_reason(JournalContents((), 1, "other", 1000.0, False), 1001.0, lambda _: True)


def test_who_listens() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        assert any_reachable([f"http://127.0.0.1:{port}/", "http://127.0.0.1:1/", "nonsense"])
    assert not any_reachable([f"http://127.0.0.1:{port}/", "nonsense", "http://127.0.0.1:99999/"])
    assert not any_reachable([])


class Answers:
    """Calls to nodes, answered as the test says."""

    def __init__(self, answers: dict[str, Any]) -> None:
        self.answers = answers
        self.asked: list[tuple[str, str]] = []

    def call(self, uri: str, method: str, params: Any, on_done: Callable[[Any, Any], object]) -> None:
        self.asked.append((uri, method))
        answer = self.answers[method]
        on_done(*((None, answer) if isinstance(answer, Exception) else (answer, None)))


def refused() -> UnreachableError:
    error = UnreachableError("cannot connect")
    error.__cause__ = ConnectionRefusedError()
    return error


PUBLISHER = RegisteredNode("/n", "http://h:1/", frozenset({"/t"}), frozenset({"/s"}))
SERVANT = RegisteredNode("/n", "http://h:1/", frozenset(), frozenset())


@pytest.mark.parametrize(
    ("node", "answers", "there", "asked"),
    [
        (PUBLISHER, {"getPublications": [1, "", [["/t", "x"]]]}, True, 1),
        (PUBLISHER, {"getPublications": [1, "", []], "getSubscriptions": [1, "", [["/s", "x"]]]}, True, 2),
        (PUBLISHER, {"getPublications": [1, "", [["/x", "x"]]], "getSubscriptions": [1, "", [3]]}, False, 2),
        (PUBLISHER, {"getPublications": refused()}, False, 1),
        (PUBLISHER, {"getPublications": XmlRpcFault(1, "no such method")}, True, 1),
        (SERVANT, {"getPid": [1, "", 4]}, True, 1),
        (SERVANT, {"getPid": refused()}, False, 1),
    ],
)
def test_who_is_there(node: RegisteredNode, answers: dict[str, Any], there: bool, asked: int) -> None:
    caller: Any = Answers(answers)
    gone: list[RegisteredNode] = []
    counts: list[int] = []
    nobody: Any = None
    revival = Recovery(nobody, caller, [node], lambda known, why: gone.append(known), counts.append)
    revival.start()
    assert (gone == []) is there
    assert counts == [int(there)]
    assert len(caller.asked) == asked


def test_a_silent_node_is_asked_again() -> None:
    loop = Loop("test")
    loop.start()
    caller = RpcCaller(loop, timeout=0.05)
    ended = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as server:
        api = f"http://127.0.0.1:{server.getsockname()[1]}/"
        node = RegisteredNode("/n", api, frozenset(), frozenset())
        revival = Recovery(loop, caller, [node], lambda *_: ended.set(), lambda _: ended.set())
        loop.call_soon(revival.start)
        server.settimeout(10)
        connection, _ = server.accept()
        connection.recv(1)
        assert not ended.wait(0.2), "no answer says nothing"
        connection.close()
        loop.run(revival.close)
        caller.close()
    loop.stop()


def test_a_master_goes_on_where_another_stopped(tmp_path: Path) -> None:
    path = tmp_path / "m.journal"
    first = Master(port=0, bind_host="127.0.0.1", journal=Journal(path, print))
    first.start()
    told: list[Any] = []
    came = threading.Event()

    def continued(here: int, gone: list[str]) -> None:
        told.extend((here, gone))
        came.set()

    with socket.create_server(("127.0.0.1", 0)) as server:
        gone = f"http://127.0.0.1:{server.getsockname()[1]}/"
    client = MasterClient("/a", first.uri)
    client.register_publisher("/t", "std_msgs/String", gone)
    client.set_param("/x", {"y": 1})
    client.close()
    until = time.monotonic() + 10
    while True:  # a thread writes
        previous = read_journal(path)
        if previous is not None and len(previous.calls) >= 4:
            break
        assert time.monotonic() < until
    first.stop()
    assert not path.exists()
    second = Master(
        port=0,
        bind_host="127.0.0.1",
        journal=Journal(path, print),
        previous=previous,
        on_restored=continued,
    )
    second.start()
    assert came.wait(10)
    client = MasterClient("/b", second.uri)
    assert client.get_param("/x") == {"y": 1}
    assert client.get_system_state()[0] == []
    assert told == [0, ["/a"]]
    client.close()
    second.stop()


@pytest.mark.slow
def test_a_broken_journal_is_not_begun_anew_with_each_change(
    journal: Callable[..., Journal], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As that takes the whole state each time: with a full disk, or one that hangs."""
    go_on = threading.Event()

    def hang(*_: object) -> None:
        go_on.wait(20)
        raise OSError(errno.EIO, "Input/output error")

    writer = journal(log=lambda _: None)
    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", hang)
        writer.rewrite([])
        writer.rewrite([("setParam", ["/a", "/", {"x": "x" * (70 << 20)}])])
        writer.add(("setParam", ["/a", "/x", 1]))
        assert not writer.has_grown and not writer.needs_rewrite, "the writer has enough to do"
        go_on.set()
        until = time.monotonic() + 20
        while not writer.needs_rewrite:
            assert time.monotonic() < until
        assert not writer.has_grown


def test_only_nodes_that_were_there_at_the_end_count_as_left() -> None:
    ended = [
        call
        for number in range(200)
        for call in (
            ("registerSubscriber", [f"/tool{number}", "/t", "*", f"http://h:{number}/"]),
            ("unregisterSubscriber", [f"/tool{number}", "/t", f"http://h:{number}/"]),
        )
    ]
    calls = (*ended, ("registerPublisher", ["/a", "/t", "*", "http://robot:1/"]))
    asked: list[set[str]] = []
    stale_reason(JournalContents(calls, 1, boot_id(), 1000.0, False), 2000.0, lambda apis: not asked.append(set(apis)))
    assert asked == [{"http://robot:1/"}]


def test_an_early_year_can_be_read_again() -> None:
    call = ("setParam", ("/a", "/x", datetime.datetime(1, 2, 3, 4, 5, 6)))
    (previous,) = journals.decode_records(encode_record(call))
    assert previous is not None and list(previous[1]) == list(call[1])


def test_its_thread_does_not_keep_a_program_from_ending(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "master.journal", print)
    journal.rewrite(())
    (thread,) = [thread for thread in threading.enumerate() if thread.name == "master: journal"]
    assert thread.daemon
    journal.close(remove=True)


def test_calls_that_change_what_is_registered_are_journaled() -> None:
    changing = ("register", "unregister", "setParam", "deleteParam", "subscribeParam", "unsubscribeParam")
    assert {name for name, method in METHODS.items() if method.changes_state} == {
        name for name in METHODS if name.startswith(changing)
    }
