"""Masters that are not stock's: with methods missing, with other words, and with faults of several styles.

Feature: nodes and tools work with masters that have fewer methods, such as @foxglove/ros1's `roscore` -- missing
    methods are worked around, or reported
"""

from __future__ import annotations

import io
import threading
from collections.abc import Callable, Iterator
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from xmlrpc.client import Fault, dumps, loads

import pytest

from pyros1.cli.main import entry
from pyros1.ground.errors import Error, MasterMethodError, ParameterNotSetError
from pyros1.master.server import Master
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.net.hosts import parse_uri
from pyros1.net.master_client import MasterClient
from pyros1.node import Node

pytestmark = pytest.mark.once

DEADLINE = 20.0
Change = Callable[[list[Any]], Any]

STYLES = {
    "fault 1": dumps(Fault(1, "not supported"), methodresponse=True).encode(),
    "fault -32601": dumps(Fault(-32601, "method not found"), methodresponse=True).encode(),
    "fault in words": dumps(Fault("NoSuchMethod", "no"), methodresponse=True).encode(),  # type: ignore[arg-type]
    "404": b"",
    "500": b"",
}


class LesserMaster:
    """A master of pyros1 behind a server that does not pass everything on.

    Args:
        master: does the work.
        missing: methods that it does not have.
        style: how it says so.
        answers: method -> makes another answer from the real one.
    """

    def __init__(self, master: Master, missing: set[str], style: str, answers: dict[str, Change] | None = None) -> None:
        host, port = parse_uri(master.uri)
        changes = answers or {}

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"
            wbufsize = -1  # an answer is one write: two would wait 40 ms for the peer's word that the first has come

            def do_POST(self) -> None:
                params, method = loads(self.rfile.read(int(self.headers["Content-Length"])))
                if method in missing:
                    self.answer(int(style) if style.isdigit() else 200, STYLES[style])
                    return
                value: Any
                if method == "system.multicall":
                    calls: Any = params[0]
                    value = [self.one_of_many(call["methodName"], call["params"]) for call in calls]
                else:
                    value = self.real(str(method), params)
                self.answer(200, dumps((value,), methodresponse=True).encode())

            def one_of_many(self, method: str, params: Any) -> Any:
                if method in missing:
                    return {"faultCode": 1, "faultString": f"no {method}"}
                return [self.real(method, tuple(params))]

            def real(self, method: str, params: Any) -> Any:
                connection = HTTPConnection(host, port, timeout=DEADLINE)
                connection.request("POST", "/", dumps(params, method).encode(), {"Content-Type": "text/xml"})
                ((triple,), _) = loads(connection.getresponse().read())
                connection.close()
                change = changes.get(method)
                return change(triple) if change else triple  # type: ignore[arg-type]

            def answer(self, status: int, body: bytes) -> None:
                self.send_response(status)
                self.send_header("Content-Type", "text/xml")
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, format: str, *args: object) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = False
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.01,))
        self._thread.start()
        self.uri = f"http://127.0.0.1:{self._server.server_port}/"

    def close(self) -> None:
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()


@pytest.fixture
def lesser(master: Master, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., LesserMaster]]:
    made: list[LesserMaster] = []

    def make(*missing: str, style: str = "fault 1", answers: dict[str, Change] | None = None) -> LesserMaster:
        made.append(LesserMaster(master, set(missing), style, answers))
        monkeypatch.setenv("ROS_MASTER_URI", made[-1].uri)
        monkeypatch.setenv("ROS_HOSTNAME", "localhost")
        return made[-1]

    yield make
    for each in made:
        each.close()


NEEDED = ["registerPublisher", "registerSubscriber", "registerService", "lookupService", "getParam", "setParam"]
"""Without these a part of a node's life is not possible, and an error says so."""
SPARED = ["getPid", "getUri", "system.multicall", "lookupNode", "getTopicTypes", "getPublishedTopics"]
SPARED += ["getSystemState", "unregisterPublisher", "unregisterSubscriber", "unregisterService"]
SPARED += ["deleteParam", "searchParam", "hasParam", "getParamNames", "subscribeParam", "unsubscribeParam"]
METHODS = [*NEEDED, *SPARED]


class Life:
    """A node's life, each part of which may fail with an Error, and with nothing else."""

    def __init__(self, uri: str) -> None:
        self.uri = uri
        self.failed: dict[str, str] = {}

    def attempt(self, name: str, action: Callable[[], Any]) -> Any:
        try:
            return action()
        except MasterMethodError as error:
            self.failed[name] = str(error)
            return None
        except Error as error:
            assert isinstance(error.__cause__, MasterMethodError), error
            self.failed[name] = str(error)
            return None

    def run(self) -> None:
        environ = {"ROS_MASTER_URI": self.uri, "ROS_HOSTNAME": "localhost"}
        came = threading.Event()
        with Node("lone", argv=["_rate:=5"], environ=environ, handle_signals=False) as node:
            self.attempt("subscribe", lambda: node.subscribe("t", Float64, lambda message: came.set()))
            publisher = self.attempt("advertise", lambda: node.advertise("t", Float64, latch=True))
            if publisher is not None:
                publisher.publish(Float64(1.0))
            if not self.failed:
                assert came.wait(DEADLINE)
            self.attempt("provide", lambda: node.advertise_service("s", "std_srvs/Empty", lambda request: {}))
            if "provide" not in self.failed:
                self.attempt("call", node.service("s", "std_srvs/Empty"))
                self.attempt("wait", lambda: node.wait_for_service("s", 1.0))
            self.attempt("set", lambda: node.params.set("~other", [1, "two"]))
            if "set" not in self.failed:
                self.attempt("get", lambda: self.check_parameters(node))
                self.attempt("delete", lambda: node.params.__delitem__("~other"))

    def check_parameters(self, node: Node) -> None:
        assert node.params["~rate"] == 5
        assert node.params.get("~none", 7) == 7
        assert "~rate" in node.params and "~none" not in node.params
        assert node.params.search("rate") == "/lone/rate"
        assert node.params.search("none") is None
        assert {"/lone/other", "/lone/rate"} <= set(node.params.names())
        assert node.params.cached("~rate") == 5
        assert node.params.cached("~none", 7) == 7
        node.params.uncache("~rate")


@pytest.mark.parametrize("style", STYLES)
def test_a_nodes_whole_life_with_the_least_master(lesser: Any, style: str) -> None:
    """Only deleting a parameter cannot be done another way."""
    life = Life(lesser(*set(SPARED) - {"getPublishedTopics", "getSystemState"}, style=style).uri)
    life.run()
    assert set(life.failed) == {"delete"}


@pytest.mark.parametrize("method", METHODS)
def test_a_nodes_whole_life_without(lesser: Any, method: str) -> None:
    life = Life(lesser(method, style=list(STYLES)[METHODS.index(method) % len(STYLES)]).uri)
    life.run()
    expected = {
        "registerPublisher": {"advertise"},
        "registerSubscriber": {"subscribe"},
        "registerService": {"provide"},
        "lookupService": {"call", "wait"},
        "getParam": {"get"},
        "setParam": {"set"},
        "deleteParam": {"delete"},
    }
    assert set(life.failed) == expected.get(method, set())
    assert all(method in text for text in life.failed.values())


COMMANDS = """
topic list | topic list -v | topic list --host | topic list --json | topic info /t
topic type /t | topic find std_msgs/Float64
node list | node list -a | node info /other | node machine | node machine localhost
service list | service list -n | service info /s | service type /s | service uri /s | service node /s | service args /s
service find std_srvs/Empty | service call /s
param list | param set /p 3 | param get /p | param get /lone | param get /none | param dump | param delete /p
topic echo -n 1 /t| topic hz --help
log list /other | log get /other rosout | log set /other rosout warn | dynparam list
node cleanup | master --help | node kill /other
"""


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_every_command_without(
    lesser: Any, make_node: Any, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], method: str
) -> None:
    """Each works, or says in a line what the master lacks."""
    style = list(STYLES)[METHODS.index(method) % len(STYLES)]
    other = make_node("other")
    other.advertise("t", Float64, latch=True).publish(Float64(1.0))
    other.advertise_service("s", "std_srvs/Empty", lambda request: {})
    other.params["/lone/rate"] = other.params["/p"] = 5
    lesser(method, style=style)
    monkeypatch.setattr("sys.stdin", io.StringIO("n\n"))  # to what cleanup asks
    failed = {}
    for line in COMMANDS.replace("\n", "|").split("|"):
        if not line.strip():
            continue
        try:
            code = entry(["pyros1", *line.split()])
        except SystemExit as end:
            code = int(end.code or 0)
        out, err = capfd.readouterr()
        assert "Traceback" not in out + err
        if code:
            failed[line.strip()] = err
    failed.pop("param get /none")
    if not method.startswith("unregister"):  # what commands leave behind at such a master does not answer
        assert all(method in text for text in failed.values()), failed
    if method in ("getPid", "getUri", "system.multicall", "hasParam", "searchParam", "getPublishedTopics"):
        assert not failed


@pytest.mark.parametrize("line", ["topic pub -1 /u std_msgs/Float64 1.0", "node ping -c 1 /other", "wtf"])
def test_slow_commands_with_the_least_master(
    lesser: Any, make_node: Any, line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.cli.commands.topic.pub.HOLD_SECONDS", 0.1)
    make_node("other")
    lesser(*set(SPARED) - {"getPublishedTopics", "getSystemState", "lookupNode"})
    assert entry(["pyros1", *line.split()]) == 0


def test_a_refusal_in_other_words_and_no_namespaces(lesser: Any, master: Master) -> None:
    """As @foxglove/ros1 has it: 0 and no text for what is not set, values only under their full names."""

    def only_leaves(triple: list[Any]) -> list[Any]:
        return [0, "", {}] if triple[0] != 1 or isinstance(triple[2], dict) else triple

    uri = lesser("system.multicall", "getPid", answers={"getParam": only_leaves, "searchParam": only_leaves}).uri
    client = MasterClient("/lone", uri)
    try:
        client.set_param("/a", {"b": {"c": 1}, "d": "two"})
        assert client.get_param("/a") == {"b": {"c": 1}, "d": "two"}
        assert client.get_param("/a/b") == {"c": 1}
        with pytest.raises(ParameterNotSetError):
            client.get_param("/none")
        assert client.search_param("none") is None
    finally:
        client.close()


def test_a_master_that_does_not_know_any_type(lesser: Any, make_node: Any, environ: dict[str, str]) -> None:
    """It refuses ``*`` for a topic that has a type."""
    make_node("talker").advertise("t", Float64, latch=True).publish(Float64(2.0))
    refused = []

    def refuse(triple: list[Any]) -> list[Any]:
        refused.append(triple)
        return [0, "topic_type does not match", []] if len(refused) == 1 else triple

    lesser("system.multicall", "getPid", answers={"registerSubscriber": refuse})
    assert entry(["pyros1", "topic", "echo", "-n", "1", "/t"]) == 0
    assert len(refused) == 2


WRONG: dict[str, list[Any]] = {
    "getPid": ["1", [], {}],
    "getUri": [1],
    "lookupNode": [1, [], {"a": 1}],
    "lookupService": [0],
    "getSystemState": [7, [[], []], [[["/t"]], [], []], [[["/t", [1]]], [], []], [[], [], ["/s"]], [{}, [], []]],
    "getTopicTypes": ["x", [1], [["/t"]], [["/t", 1]]],
    "getPublishedTopics": [{"a": 1}, [["/t", "a", "b"]]],
}


def test_answers_of_another_form_are_errors_that_name_the_method(lesser: Any) -> None:
    wrong: list[Any] = []
    answers = {method: lambda triple: [1, "", wrong[0]] for method in WRONG}
    client = MasterClient("/me", lesser(answers=answers).uri)
    calls: dict[str, Callable[[], Any]] = {
        "getPid": client.get_pid,
        "getUri": client.get_uri,
        "lookupNode": lambda: client.lookup_node("/x"),
        "lookupService": lambda: client.lookup_service("/x"),
        "getSystemState": client.get_system_state,
        "getTopicTypes": client.get_topic_types,
        "getPublishedTopics": client.get_published_topics,
    }
    for method, values in WRONG.items():
        for value in values:
            wrong[:] = [value]
            with pytest.raises(MasterMethodError, match=rf"cannot execute {method}|cannot execute get"):
                calls[method]()
    client.close()


@pytest.mark.parametrize("odd", [7, ["no uri", 5, {}]])
def test_publishers_of_another_form_hide_no_other(lesser: Any, make_node: Any, odd: Any) -> None:
    make_node("talker").advertise("t", Float64, latch=True).publish(Float64(2.0))
    came = threading.Event()

    def change(triple: list[Any]) -> list[Any]:
        return [*triple[:2], [*odd, *triple[2]] if isinstance(odd, list) else odd]

    uri = lesser(answers={"registerSubscriber": change}).uri
    environ = {"ROS_MASTER_URI": uri, "ROS_HOSTNAME": "localhost"}
    with Node("lone", argv=[], environ=environ, handle_signals=False) as node:
        node.subscribe("t", Float64, lambda message: came.set())
        assert not isinstance(odd, list) or came.wait(DEADLINE)
