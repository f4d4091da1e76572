"""serial_node.py with simulated boards.

Feature: boards with rosserial, such as Arduinos -- `pyros1 run rosserial_python serial_node.py /dev/ttyACM0`, or `tcp`;
    serial lines need the extra `serial`
"""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable
from queue import Queue
from typing import Any

import pytest

from pyros1.ground.errors import ServiceError, SettingError
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray
from pyros1.msgs.rosserial_msgs.msg import Log
from pyros1.msgs.rosserial_msgs.srv import RequestParamRequest, RequestParamResponse
from pyros1.msgs.std_msgs.msg import Bool, String, Time
from pyros1.msgs.std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse
from pyros1.robot_nodes.rosserial_python.node import SerialNode
from pyros1.robot_nodes.rosserial_python.ports import PortError, SerialPort

from ...bodies import decode
from .conftest import PATIENCE, Board, frame, topic_info

pytest.importorskip("serial", reason="the extra `serial` brings it")

CHATTER = topic_info(0, 125, "chatter", "std_msgs/String", String._md5sum)
LED = topic_info(1, 100, "led", "std_msgs/Bool", Bool._md5sum, 16)
ASK = SetBoolRequest
ANSWER = SetBoolResponse
MOTOR = topic_info(2, 126, "motor", "std_srvs/SetBool", ANSWER._md5sum)
MOTOR += topic_info(3, 101, "motor", "std_srvs/SetBool", ASK._md5sum)
LIGHT = topic_info(4, 127, "light", "std_srvs/SetBool", ASK._md5sum)
LIGHT += topic_info(5, 102, "light", "std_srvs/SetBool", ANSWER._md5sum)
OTHER = topic_info(0, 128, "other", "std_msgs/String", "0" * 32)
UNKNOWN = topic_info(0, 129, "unknown", "no_msgs/Such", "0" * 32)


def test_everything_that_a_board_can_do(device: Any, make_node: Callable[..., Any]) -> None:
    board: Board = device.plug([CHATTER, LED, MOTOR, LIGHT, OTHER, UNKNOWN])
    host, peer = make_node("serial_node"), make_node("peer")
    peer.params["/serial_node/gains"] = [0.5, 1.5]
    peer.advertise_service("light", SetBool, lambda request: (request.data, "by peer"))
    led = peer.advertise("led", Bool, latch=True)
    led.publish(True)
    heard: Queue[str] = Queue()
    peer.subscribe("chatter", String, lambda message: heard.put(message.data))
    SerialNode(host, [str(device.path)])

    assert board.wait(100) == [b"\x01"]  # a latched message comes to the board
    # Garbage, and a message of which a byte is wrong, do no harm.
    wrong = bytearray(frame(125, b"\x03\0\0\0bad"))
    wrong[-2] ^= 4
    while heard.empty():  # until the subscriber is connected
        board.write(b"noise\xff" + bytes(wrong))
        board.send(125, String("hello"))
        time.sleep(0.01)
    assert heard.get() == "hello"

    board.send(10, Time())
    stamp = decode(Time, board.wait(10)[0])
    assert abs(stamp.data.to_sec() - host.now().to_sec()) < 60
    board.send(6, RequestParamRequest("~gains"))
    [found] = board.wait(6)
    assert list(decode(RequestParamResponse, found).floats) == [0.5, 1.5]
    board.send(127, ASK(True))
    [found] = board.wait(102)
    assert decode(ANSWER, found) == ANSWER(True, "by peer")
    board.send(7, Log(level=Log.ERROR, msg="motor stalled"))

    answers: Queue[Any] = Queue()
    caller = threading.Thread(target=lambda: answers.put(peer.service("motor", SetBool)(True)), name="caller")
    caller.start()
    assert board.wait(101) == [b"\x01"]
    board.send(126, ANSWER(True, "turning"))
    assert answers.get() == ANSWER(True, "turning")
    caller.join()

    host.shutdown()
    assert board.wait(11) == [b""]  # the board is told
    assert all(topic_id >= 0 for topic_id, _ in board.frames)


def test_what_is_wrong_is_said_in_one_line(
    device: Any, make_node: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    board: Board = device.plug([OTHER, UNKNOWN, LED])
    host, peer = make_node("serial_node"), make_node("peer")
    text = peer.advertise("led", Bool, latch=True)
    text.publish(False)
    SerialNode(host, [str(device.path), "115200"])
    board.wait(100)
    host.shutdown()
    found = capfd.readouterr()
    assert f"Connected to {device.path} at 115200 baud" in found.out
    lines = found.err.splitlines()
    assert sum("the board's std_msgs/String is not the one here (md5 sum '000" in line for line in lines) == 1
    assert sum("cannot create the board's publisher unknown: " in line for line in lines) == 1
    assert len(lines) == 2


@pytest.mark.slow
def test_an_absent_device_and_one_that_is_unplugged(
    device: Any, make_node: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    host, peer = make_node("serial_node"), make_node("peer")
    states: Queue[Any] = Queue()
    peer.params["/serial_node/port"] = str(device.path)
    peer.params["/serial_node/baud"] = "9600"
    SerialNode(host, [])
    peer.subscribe("/diagnostics", DiagnosticArray, lambda message: states.put(message.status[0]))
    status = states.get()
    assert (status.level, status.name) == (2, "rosserial_python") and "plug the board in" in status.message
    assert next((value.key, value.value) for value in status.values) == ("last sync", "never")

    board: Board = device.plug([LED])
    board.until(lambda board: board.requests)
    while (status := states.get()).level:
        pass
    assert status.message == "connected" and status.hardware_id == str(device.path)

    device.unplug()
    while not (status := states.get()).level:
        pass
    device.plug([LED, CHATTER]).until(lambda board: board.requests)
    host.shutdown()
    found = capfd.readouterr()
    assert found.err.count(f"{device.path} was unplugged") == 1
    assert found.out.count(f"Connected to {device.path} at 9600 baud") == 2
    assert 2 <= found.err.count("trying again every 1 s") <= 3 and found.err.count("Traceback") == 0


def test_boards_come_by_tcp_one_after_the_other(tcp_board: Callable[..., Any], make_node: Callable[..., Any]) -> None:
    host = make_node("serial_node", argv=["_tcp_port:=0"])
    server = SerialNode(host, ["tcp"])
    first, second = (tcp_board(server.tcp_port, [topics]) for topics in (LED, CHATTER))
    first.until(lambda board: board.requests)
    assert second.requests == 0
    first.hang_up()
    second.until(lambda board: board.requests)


def test_a_silent_board_is_asked_again_and_a_lost_one_is_disconnected(
    tcp_board: Callable[..., Any],
    make_node: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("pyros1.robot_nodes.rosserial_python.session.ASK_PERIOD", 0.05)
    host = make_node("serial_node", argv=["_tcp_port:=0"])
    board = tcp_board(SerialNode(host, ["tcp"]).tcp_port, [])
    board.until(lambda board: board.requests >= 3)
    board.send(10, Time())
    board.wait(10)
    monkeypatch.setattr("pyros1.robot_nodes.rosserial_python.session.LOST_AFTER", 1.0)
    board.join()  # the host closes the connection
    assert "127.0.0.1: lost the board: nothing came for 1 s" in capfd.readouterr().err


def test_several_boards_at_a_time_and_calls_that_end_with_the_connection(
    tcp_board: Callable[..., Any], make_node: Callable[..., Any], until: Callable[..., None]
) -> None:
    host, peer = make_node("serial_node", argv=["_tcp_port:=0", "_fork_server:=true"]), make_node("peer")
    server = SerialNode(host, ["tcp"])
    first, second = (tcp_board(server.tcp_port, [topics]) for topics in (MOTOR, CHATTER))
    for board in (first, second):
        board.until(lambda board: board.requests)
    errors: Queue[str] = Queue()

    def call() -> None:
        try:
            peer.service("motor", SetBool)(True)
        except ServiceError as error:
            errors.put(str(error))

    peer.wait_for_service("motor", 20)
    caller = threading.Thread(target=call, name="caller")
    caller.start()
    first.wait(101)
    first.hang_up()
    assert "the connection to the board broke" in errors.get()
    caller.join()
    until(lambda: not [name for name, _ in host.master.get_system_state()[2] if name == "/motor"])


def test_a_board_that_reconnects_gets_its_services_at_once(
    tcp_board: Callable[..., Any], make_node: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    """The host does not know yet that the first connection is broken."""
    host, peer = make_node("serial_node", argv=["_tcp_port:=0", "_fork_server:=true"]), make_node("peer")
    server = SerialNode(host, ["tcp"])
    first = tcp_board(server.tcp_port, [MOTOR])
    peer.wait_for_service("motor", 20)
    second = tcp_board(server.tcp_port, [MOTOR])
    second.until(lambda board: board.requests)
    second.send(10, Time())
    second.wait(10)
    first.hang_up()
    for _ in range(2):
        answers: Queue[Any] = Queue()
        caller = threading.Thread(target=lambda: answers.put(peer.service("motor", SetBool)(True)), name="caller")  # noqa: B023
        caller.start()
        count = len([topic_id for topic_id, _ in second.frames if topic_id == 101])
        second.wait(101, count + 1)
        second.send(126, ANSWER(True, "again"))
        assert answers.get(timeout=PATIENCE) == ANSWER(True, "again")
        caller.join()
        first.join()
    host.shutdown()
    assert "already provides" not in capfd.readouterr().err


def test_a_board_cannot_flood_the_log(
    device: Any, make_node: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    board: Board = device.plug([])
    host = make_node("serial_node")
    SerialNode(host, [str(device.path)])
    board.until(lambda board: board.requests)
    for number in range(400):
        board.send(7, Log(level=Log.WARN, msg=f"flood {number}"))
        board.write(topic_info(0, 126, f"no{number}", "std_msgs/Bool", "0" * 32))
        board.write(topic_info(0, 5, f"wrong{number}", "std_msgs/Bool", Bool._md5sum))
    board.send(10, Time())
    board.wait(10)
    host.shutdown()
    lines = capfd.readouterr().err.splitlines()
    assert 200 <= sum("flood" in line for line in lines) < 300
    assert sum("is not the one here" in line for line in lines) == 20
    assert sum("which is not for topics" in line for line in lines) == 20
    assert sum("380 similar messages were suppressed" in line for line in lines) == 2


def test_ports_that_cannot_be_opened(device: Any) -> None:
    with pytest.raises(PortError, match="is not a serial line"):
        SerialPort("/dev/null", 57600)
    device.plug([])
    first = SerialPort(str(device.path), 57600)
    with pytest.raises(PortError, match="is in use by another program"):
        SerialPort(str(device.path), 57600)
    first.close()


def test_a_board_that_changes_the_types_of_its_topics(
    tcp_board: Callable[..., Any], make_node: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    host = make_node("serial_node", argv=["_tcp_port:=0"])
    others = [topic_info(0, number, "chatter", "std_msgs/Bool", Bool._md5sum) for number in (126, 127)]
    board = tcp_board(SerialNode(host, ["tcp"]).tcp_port, [CHATTER, *others])
    board.until(lambda board: board.requests)
    board.send(125, String("of the publisher that was closed"))
    board.send(10, Time())
    board.wait(10)  # the host goes on
    host.shutdown()
    assert "Traceback" not in capfd.readouterr().err


def test_a_board_that_announces_ever_more_topics(
    tcp_board: Callable[..., Any],
    make_node: Callable[..., Any],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("pyros1.robot_nodes.rosserial_python.endpoints.MAX_ENDPOINTS", 3)
    host = make_node("serial_node", argv=["_tcp_port:=0"])
    topics = [topic_info(0, 125, f"flood{number}", "std_msgs/Bool", Bool._md5sum) for number in range(9)]
    board = tcp_board(SerialNode(host, ["tcp"]).tcp_port, topics)
    board.until(lambda board: board.requests)
    board.send(10, Time())
    board.wait(10)
    assert sum(name.startswith("/flood") for name, _ in host.master.get_system_state()[0]) == 3
    host.shutdown()
    assert capfd.readouterr().err.count("already announced 3 topics and services: flood3 is ignored") == 1


def test_who_connects_and_is_no_board_is_disconnected(
    tcp_board: Callable[..., Any], make_node: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Otherwise, nobody else could connect."""
    monkeypatch.setattr("pyros1.robot_nodes.rosserial_python.session.LOST_AFTER", 0.5)
    server = SerialNode(make_node("serial_node", argv=["_tcp_port:=0"]), ["tcp"])
    stranger = socket.create_connection(("127.0.0.1", server.tcp_port), PATIENCE)
    with stranger:
        stranger.sendall(b"GET / HTTP/1.0\r\n\r\n")
        while stranger.recv(100):
            pass
        tcp_board(server.tcp_port, [CHATTER]).until(lambda board: board.requests)


def test_a_port_in_stocks_namespace_that_is_no_number(make_node: Callable[..., Any]) -> None:
    host = make_node("serial_node", argv=["_tcp_port:=0"])
    host.params["/rosserial_embeddedlinux"] = {"tcp_port": "any"}
    assert SerialNode(host, ["tcp"]).tcp_port


@pytest.mark.parametrize(
    "args", [["/dev/ttyUSB0", "fast"], ["tcp", "0"], ["tcp", "70000000000"], ["tcp", "0000000001" + "9" * 5000]]
)
def test_wrong_arguments(args: list[str], make_node: Callable[..., Any]) -> None:
    with pytest.raises(SettingError, match="is not a number: serial_node"):
        SerialNode(make_node("serial_node"), args)


def test_a_connection_that_never_sends_anything_does_not_keep_boards_out(
    tcp_board: Callable[..., Any], make_node: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.robot_nodes.rosserial_python.session.LOST_AFTER", 0.5)
    server = SerialNode(make_node("serial_node", argv=["_tcp_port:=0"]), ["tcp"])
    with socket.create_connection(("127.0.0.1", server.tcp_port)):
        tcp_board(server.tcp_port, [LED]).until(lambda board: board.requests)


def test_a_topic_that_could_not_be_replaced_comes_back(device: Any, make_node: Callable[..., Any]) -> None:
    number = topic_info(0, 126, "chatter", "std_msgs/Bool", Bool._md5sum)
    board: Board = device.plug([CHATTER])
    host, peer = make_node("serial_node"), make_node("peer")
    own = host.advertise("chatter", String)  # so that the board cannot have another type
    heard: Queue[str] = Queue()
    peer.subscribe("chatter", String, lambda message: heard.put(message.data))
    assert own.wait_for_subscribers(timeout=20)
    SerialNode(host, [str(device.path)])
    board.until(lambda board: board.requests)
    board.write(number + CHATTER)
    board.send(125, String("hello"))
    assert heard.get(timeout=20) == "hello"
