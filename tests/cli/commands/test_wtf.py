"""wtf: each defect is made, and has to be found with its cure (L178)."""

from __future__ import annotations

import json
import queue
import re
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from xmlrpc.server import SimpleXMLRPCRequestHandler, SimpleXMLRPCServer

import pytest

import pyros1
from pyros1.cli.running import run_command
from pyros1.doctor import local_facts, probe, system
from pyros1.master.server import Master
from pyros1.msgs import AnyMsg
from pyros1.msgs.dynamic import from_definition
from pyros1.msgs.rosgraph_msgs.msg import Clock, Log
from pyros1.msgs.std_msgs.msg import Int32, String
from pyros1.net.master_client import MasterClient
from pyros1.node.topic_type import topic_type

Found = dict[str, dict[str, Any]]
MakeNode = Callable[..., Any]
SOURCE = Path(pyros1.__file__).resolve().parents[1]

NODE = """
import pyros1
from pyros1.msgs.std_msgs.msg import String
node = pyros1.Node("victim", rosout=False)
node.advertise("victims_topic", String)
print("ready", flush=True)
node.spin()
"""


@pytest.fixture
def shell(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """A shell with nothing wrong, on a machine where no other ROS programs are seen."""
    for key, value in environ.items():
        monkeypatch.setenv(key, value)
    for key in ("ROS_IP", "ROS_PACKAGE_PATH", "ROS_LOG_DIR"):
        monkeypatch.delenv(key, raising=False)
    monkeypatch.setattr(local_facts, "MASTER_PORTS", range(0))
    monkeypatch.setattr(local_facts, "ros_processes", list)
    monkeypatch.setattr(system, "CONNECT_TIMEOUT", 0.05)
    return monkeypatch


@pytest.fixture
def findings(shell: pytest.MonkeyPatch, capsys: Any) -> Callable[..., Found]:
    """Run ``wtf --json``; returns its findings by kind."""

    def run(*words: str) -> Found:
        code = run_command("wtf", ["--json", *words])
        found = {each["kind"]: each for each in json.loads(capsys.readouterr().out)}
        assert code == (1 if any(each["severity"] == "error" for each in found.values()) else 0)
        assert all(each["cure"] and "\n" not in each["cure"] for each in found.values())
        return found

    return run


@pytest.fixture
def client(master: Master) -> Iterator[MasterClient]:
    """Registers what it is told to, as a node would."""
    client = MasterClient("/fake", master.uri)
    yield client
    client.close()


@contextmanager
def fake_node(
    date: str = "", connections: list[Any] | None = None, subscriptions: Any = None, asked: list[str] | None = None
) -> Iterator[str]:
    """A node that only answers questions; yields its URI.

    Args:
        date: what its HTTP answers say, if anything.
        connections: its getBusInfo.
        subscriptions: its getSubscriptions.
        asked: takes the methods that are called.
    """

    class Handler(SimpleXMLRPCRequestHandler):
        def send_header(self, keyword: str, value: str) -> None:
            super().send_header(keyword, date if keyword == "Date" and date else value)

    answers = {"getPid": 4, "getBusInfo": connections or [], "getSubscriptions": subscriptions or []}

    class Answers:
        def _dispatch(self, method: str, params: Any) -> Any:
            if asked is not None:
                asked.append(method)
            return [1, "", answers[method]]

    with SimpleXMLRPCServer(("127.0.0.1", 0), Handler, logRequests=False) as server:
        server.register_instance(Answers())
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield f"http://127.0.0.1:{server.server_address[1]}/"
        server.shutdown()
        thread.join()


@contextmanager
def node_process(code: str, environ: dict[str, str]) -> Iterator[None]:
    """A node in a process of its own, which says when it is ready and is killed afterwards."""
    command = [sys.executable, "-c", code]
    with subprocess.Popen(command, env={**environ, "PYTHONPATH": str(SOURCE)}, stdout=subprocess.PIPE) as child:
        try:
            assert child.stdout is not None and child.stdout.readline() == b"ready\n"
            yield
        finally:
            child.kill()


def test_a_healthy_system_has_no_findings_l178(
    shell: pytest.MonkeyPatch, make_node: MakeNode, capsys: Any, master: Master
) -> None:
    heard = threading.Event()
    make_node("listener", rosout=False).subscribe("chat", String, lambda message: heard.set())
    make_node("talker", rosout=False).advertise("chat", String, latch=True).publish("x")
    assert heard.wait(10)
    assert run_command("wtf", []) == 0
    out = capsys.readouterr().out
    assert "Static checks summary:\n\nNo errors or warnings" in out
    assert "running graph rules...\n... done running graph rules\n\nOnline checks summary:\n\nNo errors" in out
    assert run_command("wtf", ["--json", "--no-plugins"]) == 0 and capsys.readouterr().out == "[]\n"


# Addresses ------------------------------------------------------------------------------------------------------------


def test_a_node_with_a_host_name_that_only_it_knows(
    findings: Callable[..., Found], make_node: MakeNode, environ: dict[str, str]
) -> None:
    node = make_node("victim", rosout=False, environ={**environ, "ROS_HOSTNAME": "no-such-host.invalid"})
    node.advertise("t", String)
    found = findings()["unknown-host"]
    assert found["severity"] == "error" and "[no-such-host.invalid]" in found["text"]
    assert found["items"] == ["/victim"] and "export ROS_IP=" in found["cure"] and "/etc/hosts" in found["cure"]


def test_a_node_that_was_killed(findings: Callable[..., Found], environ: dict[str, str]) -> None:
    with node_process(NODE, environ):
        assert "dead-node" not in findings()
    found = findings()
    assert found["dead-node"]["items"][0].startswith("/victim (http://localhost:")
    assert "pyros1 node cleanup" in found["dead-node"]["cure"]
    assert "service" not in found  # its services are dead for the same reason


def test_a_host_that_swallows_everything(
    findings: Callable[..., Found], shell: pytest.MonkeyPatch, client: MasterClient
) -> None:
    shell.setattr(probe, "NODE_TIMEOUT", 0.2)
    shell.setattr(system, "NODE_TIMEOUT", 0.2)
    shell.setattr(system, "ROUND_TIMEOUT", 0.6)
    with socket.create_server(("127.0.0.1", 0), backlog=0) as full:
        callers = [socket.socket() for _ in range(2)]
        for caller in callers:  # no more are accepted; what comes then is dropped without a word
            caller.setblocking(False)
            caller.connect_ex(full.getsockname())
        client.register_publisher("/t", "std_msgs/String", f"http://127.0.0.1:{full.getsockname()[1]}/")
        found = findings()
        for caller in callers:
            caller.close()
    assert found["unreachable-host"]["items"] == ["/fake"] and "ping 127.0.0.1" in found["unreachable-host"]["cure"]


def test_a_node_that_hangs(findings: Callable[..., Found], shell: pytest.MonkeyPatch, client: MasterClient) -> None:
    shell.setattr(probe, "NODE_TIMEOUT", 0.2)
    shell.setattr(system, "NODE_TIMEOUT", 0.2)
    shell.setattr(system, "ROUND_TIMEOUT", 0.6)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        uri = f"http://127.0.0.1:{silent.getsockname()[1]}/"
        for number in range(20):
            client.register_subscriber(f"/t{number}", "std_msgs/String", uri)
        client.register_service("/s", uri.replace("http", "rosrpc").rstrip("/"), uri)
        found = findings()
    assert found["hung-node"]["items"] == [f"/fake ({uri})"] and "kill -CONT" in found["hung-node"]["cure"]
    assert "unreachable-host" not in found


def test_something_else_at_a_nodes_port(findings: Callable[..., Found], client: MasterClient) -> None:
    with SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        client.register_publisher("/t", "std_msgs/String", f"http://127.0.0.1:{server.server_address[1]}/")
        found = findings()
        server.shutdown()
        thread.join()
    assert "/fake" in found["broken-node"]["items"][0] and "node cleanup" in found["broken-node"]["cure"]


@pytest.mark.parametrize(
    ("variable", "value", "part"),
    [
        ("ROS_IP", "203.0.113.9", "does not appear to be an address of a local network interface"),
        ("ROS_HOSTNAME", "no-such-host.invalid", "cannot be resolved"),
        ("ROS_HOSTNAME", "http://me", "neither a host name nor an IP address"),
    ],
)
def test_an_address_that_is_not_of_this_machine(
    findings: Callable[..., Found], shell: pytest.MonkeyPatch, variable: str, value: str, part: str
) -> None:
    shell.delenv("ROS_HOSTNAME")
    shell.setenv(variable, value)
    found = findings("--offline")["own-address"]
    assert variable in found["text"] and part in found["text"] and "export" in found["cure"]


def test_local_addresses_although_the_master_is_elsewhere(
    findings: Callable[..., Found], shell: pytest.MonkeyPatch
) -> None:
    shell.setenv("ROS_MASTER_URI", "http://203.0.113.9:11311")
    found = findings("--offline")
    assert "is only valid on this machine" in found["own-address"]["text"] and "ROS_IP=" in found["own-address"]["cure"]


# Topics and types -----------------------------------------------------------------------------------------------------


def test_publisher_and_subscriber_of_different_types(
    findings: Callable[..., Found], make_node: MakeNode, transport: str
) -> None:
    make_node("listener", rosout=False).subscribe("t", Int32, lambda message: None)
    make_node("talker", rosout=False).advertise("t", String)
    found = findings()
    assert found["type-mismatch"]["text"].endswith("std_msgs/Int32, std_msgs/String")
    assert found["type-mismatch"]["items"] == [
        "publisher /talker: std_msgs/String",
        "subscriber /listener: std_msgs/Int32",
    ]
    assert "remap" in found["type-mismatch"]["cure"]
    assert "missing-link" not in found  # that is why


def test_two_publishers_of_different_types(findings: Callable[..., Found], make_node: MakeNode) -> None:
    make_node("one", rosout=False).advertise("t", String)
    make_node("two", rosout=False).advertise("t", Int32)
    assert findings()["type-mismatch"]["items"] == ["publisher /one: std_msgs/String", "publisher /two: std_msgs/Int32"]


def test_one_type_with_two_definitions(findings: Callable[..., Found], make_node: MakeNode) -> None:
    make_node("new", rosout=False).advertise("t", String)
    make_node("old", rosout=False).advertise("t", from_definition("std_msgs/String", "string text\n"))
    found = findings()["md5-mismatch"]
    assert "different definitions of std_msgs/String" in found["text"] and len(found["items"]) == 2
    assert "pyros1 msg md5 std_msgs/String" in found["cure"]


def test_messages_that_do_not_end_where_they_should(findings: Callable[..., Found], make_node: MakeNode) -> None:
    """A board sends a checksum byte with each message."""
    node = make_node("board", rosout=False)
    for name, body in (("odd", b"\5\0\0\0\x55"), ("cut", b"\5\0\0\0abc"), ("fine", b"\5\0\0\0"), ("silent", None)):
        cls = String if name == "cut" else Int32
        publisher = node.advertise(name, AnyMsg, raw_type=topic_type(cls), latch=True)
        make_node(f"listener_{name}", rosout=False).subscribe(name, cls, lambda message: None)
        if body is not None:
            publisher.publish(AnyMsg(body))
    found = findings()["odd-ends"]
    assert found["items"] == [
        "/board: /cut (std_msgs/String): 2 bytes missing",
        "/board: /odd (std_msgs/Int32): 1 byte too many",
    ]
    assert found["severity"] == "warning" and "rosserial" in found["cure"]


def test_nearly_the_same_name(findings: Callable[..., Found], make_node: MakeNode) -> None:
    make_node("driver", rosout=False).subscribe("cmd_vel", String, lambda message: None)
    make_node("teleop", rosout=False).advertise("cmd_val", String)
    make_node("lonely", rosout=False).subscribe("something_else", String, lambda message: None)
    found = findings()
    assert found["near-miss"]["items"] == ["/driver subscribes to /cmd_vel; /teleop publishes /cmd_val"]
    assert "FROM:=TO" in found["near-miss"]["cure"]
    assert found["no-publisher"]["items"] == ["/lonely: /something_else"]


def test_simulated_time_without_a_clock(
    findings: Callable[..., Found], make_node: MakeNode, client: MasterClient
) -> None:
    client.set_param("/use_sim_time", True)
    found = findings()["no-clock"]
    assert found["severity"] == "error" and "param set /use_sim_time false" in found["cure"]
    make_node("simulator", rosout=False).advertise("/clock", Clock)
    assert "no-clock" not in findings()
    client.set_param("/use_sim_time", False)
    assert findings()["unused-clock"]["items"] == ["/simulator"]


def test_a_link_that_is_missing(
    findings: Callable[..., Found], shell: pytest.MonkeyPatch, make_node: MakeNode, client: MasterClient
) -> None:
    shell.setattr(probe, "NODE_TIMEOUT", 1.0)
    make_node("talker", rosout=False).advertise("t", String)
    asked: list[str] = []
    with fake_node(subscriptions=[["/t", "std_msgs/String"]], asked=asked) as uri:
        client.register_subscriber("/t", "std_msgs/String", uri)
        found = findings()["missing-link"]
    assert found["items"] == ["/talker->/fake (/t)"] and "firewall" in found["cure"]
    assert set(asked) - {"publisherUpdate"} == {"getBusInfo", "getPid", "getSubscriptions"}
    assert asked.count("publisherUpdate") <= 1, "by the master, when it registers"


@pytest.mark.parametrize("nonsense", [5, ["/t"], [[]], {"/t": 5}])
def test_a_subscriber_that_answers_nonsense(
    findings: Callable[..., Found], make_node: MakeNode, client: MasterClient, nonsense: Any
) -> None:
    make_node("talker", rosout=False).advertise("t", String)
    with fake_node(subscriptions=nonsense) as uri:
        client.register_subscriber("/t", "std_msgs/String", uri)
        assert findings()["missing-link"]["items"] == ["/talker->/fake (/t)"]


def test_those_who_are_asked_log_nothing(findings: Callable[..., Found], make_node: MakeNode) -> None:
    heard: queue.Queue[str] = queue.Queue()
    make_node("watcher", rosout=False).subscribe("/rosout", Log, lambda log: heard.put(f"{log.name}: {log.msg}"))
    listener = make_node("listener")
    listener.subscribe("t", Int32, lambda message: None)
    make_node("talker", rosout=False).advertise("t", String)
    assert "refused the connection" in heard.get(timeout=10)
    assert "type-mismatch" in findings()
    listener.log.warn("next")
    assert heard.get(timeout=10) == "/listener: next"


def test_a_link_that_the_master_does_not_know(
    findings: Callable[..., Found], make_node: MakeNode, client: MasterClient
) -> None:
    make_node("talker", rosout=False).advertise("t", String)
    with fake_node(connections=[[1, "/talker", "o", "TCPROS", "/t", True]]) as uri:
        client.register_publisher("/other", "std_msgs/String", uri)
        assert findings()["unexpected-link"]["items"] == ["/fake->/talker (/t)"]


# Services, clocks, masters --------------------------------------------------------------------------------------------


def test_a_service_that_does_not_answer(findings: Callable[..., Found], client: MasterClient, closed_port: int) -> None:
    with fake_node() as uri:
        client.register_service("/broken", f"rosrpc://localhost:{closed_port}", uri)
        found = findings()["service"]
    assert "service [/broken] appears to be malfunctioning" in found["items"][0] and "restart" in found["cure"]


def test_a_clock_that_is_wrong(findings: Callable[..., Found], client: MasterClient) -> None:
    with fake_node(date="Sat, 01 Jan 2000 00:00:00 GMT") as uri:
        client.register_publisher("/t", "std_msgs/String", uri)
        found = findings()["clock-skew"]
    assert "clock of [127.0.0.1] is" in found["text"] and "behind" in found["text"] and "chrony" in found["cure"]


# A machine whose clock is wrong is a program for which it is.
SLOW = "import time; right = time.time; time.time = lambda: right() - 3600"


def test_the_wrong_clock_of_a_node_of_ours(findings: Callable[..., Found], environ: dict[str, str]) -> None:
    with node_process(SLOW + NODE, environ):
        found = findings()["clock-skew"]
    assert found["severity"] == "error"
    assert re.search(r"clock of \[\S+\] is (3599|3600|3601) s behind this machine's", found["text"])
    with node_process(NODE, environ):
        assert "clock-skew" not in findings()


def test_several_masters(findings: Callable[..., Found], shell: pytest.MonkeyPatch, master: Master) -> None:
    other = Master(port=0, bind_host="127.0.0.1")
    other.start()
    try:
        shell.setattr(local_facts, "MASTER_PORTS", [other.port])
        found = findings()["several-masters"]
        assert len(found["items"]) == 2 and "ROS_MASTER_URI" in found["cure"]
        shell.setenv("ROS_MASTER_URI", "http://localhost:1")
        assert f"export ROS_MASTER_URI=http://localhost:{other.port}/" in findings()["no-master"]["cure"]
    finally:
        other.stop()


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="the system does not tell what others run with")
def test_a_program_with_another_master(
    findings: Callable[..., Found], shell: pytest.MonkeyPatch, environ: dict[str, str]
) -> None:
    code = (
        "import socket, sys; s = socket.create_server(('127.0.0.1', 0)); print('ready', flush=True); sys.stdin.read()"
    )
    command = [sys.executable, "-c", code]
    with subprocess.Popen(
        command,
        env={**environ, "ROS_MASTER_URI": "http://elsewhere:11311"},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    ) as child:
        assert child.stdout is not None and child.stdout.readline() == b"ready\n"
        shell.undo()
        mine = [each for each in local_facts.ros_processes() if each.pid == child.pid]
        child.communicate()
    assert mine[0].master_uri == "http://elsewhere:11311" and mine[0].host == "localhost"


# Machine, packages, launch files --------------------------------------------------------------------------------------


def test_environment(findings: Callable[..., Found], shell: pytest.MonkeyPatch, tmp_path: Path) -> None:
    shell.setenv("ROS_PACKAGE_PATH", f"{tmp_path}:{tmp_path / 'nope'}")
    shell.setenv("ROS_MASTER_URI", "localhost")
    found = findings()
    assert (
        found["package-path"]["items"] == [str(tmp_path / "nope")]
        and "ROS_PACKAGE_PATH" in found["package-path"]["cure"]
    )
    assert "is not a valid URL" in found["master-uri"]["text"]
    assert "export ROS_MASTER_URI=http://localhost:11311" in found["master-uri"]["cure"]
    shell.setenv("ROS_MASTER_URI", "http://no-such-host.invalid:11311")
    assert "unknown host no-such-host.invalid" in findings("--offline")["master-host"]["text"]


def test_disks(findings: Callable[..., Found], shell: pytest.MonkeyPatch, tmp_path: Path) -> None:
    shell.setenv("ROS_LOG_DIR", str(tmp_path))
    shell.setattr("shutil.disk_usage", lambda folder: type("Usage", (), {"free": 4096, "total": 1 << 30}))
    shell.setattr(local_facts, "folder_size", lambda *_, **__: 2 << 30)
    found = findings("--offline")
    assert "4.1 kB of 1.1 GB are free" in found["disk-full"]["text"]
    assert "pyros1 clean purge" in found["disk-full"]["cure"]
    assert "uses 2.1 GB" in found["log-size"]["text"] and found["log-size"]["cure"] == "pyros1 clean purge --size 500"
    shell.setattr("os.access", lambda *_: False)
    assert "chown" in findings("--offline")["not-writable"]["cure"]


def test_no_master_says_how_to_get_one(
    findings: Callable[..., Found], shell: pytest.MonkeyPatch, closed_port: int, capsys: Any
) -> None:
    shell.setenv("ROS_MASTER_URI", f"http://localhost:{closed_port}")
    found = findings()["no-master"]
    assert found["severity"] == "warning" and found["cure"] == "pyros1 core"
    assert run_command("wtf", []) == 0
    out = capsys.readouterr().out
    assert (
        f"ROS Master does not appear to be running.\nOnline graph checks will not be run.\nROS_MASTER_URI is [http://localhost:{closed_port}]\n"
        in out
    )


@pytest.mark.slow
def test_a_master_that_takes_connections_and_does_not_answer(
    findings: Callable[..., Found], shell: pytest.MonkeyPatch, capsys: Any
) -> None:
    shell.setattr("pyros1.cli.commands.wtf._examine.MASTER_TIMEOUT", 0.1)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        uri = f"http://127.0.0.1:{silent.getsockname()[1]}"
        shell.setenv("ROS_MASTER_URI", uri)
        found = findings()
        assert "no-master" not in found and found["silent-master"]["severity"] == "error"
        assert f"{uri} did not answer within 0.1 s" in found["silent-master"]["text"]
        assert run_command("wtf", []) == 1
    assert "ROS Master does not answer.\nOnline graph checks will not be run.\n" in capsys.readouterr().out


def test_something_else_in_the_place_of_the_master(findings: Callable[..., Found], shell: pytest.MonkeyPatch) -> None:
    with fake_node() as uri:
        shell.setenv("ROS_MASTER_URI", uri)
        assert "using the port" in findings()["master"]["cure"]


def test_launch_files_and_packages(findings: Callable[..., Found], shell: pytest.MonkeyPatch, tmp_path: Path) -> None:
    file = tmp_path / "robot.launch"
    file.write_text('<launch>\n  <node pkg="minimal_nodes" type="minimal_publishr" name="n"/>\n</launch>\n')
    found = findings("--offline", str(file))["launch-file"]
    assert "did you mean 'minimal_publisher'?" in found["items"][0] and "launch --check" in found["cure"]
    assert "nope.launch" in findings("--offline", "/nope.launch")["launch-file"]["items"][0]
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "package.xml").write_text("<package><name>broken</name>")
    shell.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    assert "package" not in findings("--offline")
    assert "broken (" in "".join(findings("--offline", "--all")["package"]["items"])


def test_the_stock_name_returns_what_stock_returns(shell: pytest.MonkeyPatch, capsys: Any) -> None:
    shell.setenv("ROS_IP", "203.0.113.9")
    shell.delenv("ROS_HOSTNAME")
    assert run_command("wtf", ["--offline"]) == 1
    assert "\nFound 1 error(s).\n\nERROR ROS_IP may be incorrect" in capsys.readouterr().out
    shell.setattr("sys.argv", ["roswtf"])
    assert run_command("wtf", ["--offline"]) == 0
    with pytest.raises(SystemExit) as end:
        run_command("wtf", ["--bogus"])
    assert end.value.code == 2


def test_a_report_for_those_who_help(shell: pytest.MonkeyPatch, make_node: MakeNode, capsys: Any) -> None:
    make_node("talker").advertise("/chatter", String)
    assert run_command("wtf", ["--report"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("# pyros1 wtf --report\n")
    assert "| /chatter | std_msgs/String | /talker |  |" in out
    assert f"| pyros1 | {pyros1.__version__}, in " in out
    assert "| ROS_MASTER_URI | http://" in out
    assert "\x1b" not in out


def test_a_report_says_that_packages_of_this_folder_were_not_set(
    shell: pytest.MonkeyPatch, tmp_path: Path, capsys: Any
) -> None:
    shell.delenv("ROS_PACKAGE_PATH", raising=False)
    (tmp_path / "my_robot").mkdir()
    (tmp_path / "my_robot" / "package.xml").write_text("<package><name>my_robot</name></package>")
    shell.chdir(tmp_path)
    assert run_command("wtf", ["--report", "--offline"]) == 0
    said = f"| packages near this folder | {tmp_path}/my_robot; pyros1 itself adds them to ROS_PACKAGE_PATH |"
    assert said in capsys.readouterr().out
