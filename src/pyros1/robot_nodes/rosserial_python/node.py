"""serial_node.py: connects boards that use rosserial to ROS (https://wiki.ros.org/rosserial_python).

``serial_node.py [PORT [BAUD]]`` or ``serial_node.py tcp [TCP_PORT]``; the parameters are ``~port`` (/dev/ttyUSB0, or
``tcp``), ``~baud`` (57600), ``~tcp_port`` (11411) and ``~fork_server`` (false; whether several boards may be connected
at the same time).
"""

from __future__ import annotations

import socket
import sys
import threading
from contextlib import closing
from functools import partial
from typing import Any

from pyros1.ground.errors import SettingError
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray
from pyros1.net.ports import listening_socket
from pyros1.node import Node
from pyros1.node.log.levels import ERROR, INFO, WARN
from pyros1.robot_nodes.rosserial_python.board import Board
from pyros1.robot_nodes.rosserial_python.ports import Port, PortError, SerialPort, TcpPort
from pyros1.robot_nodes.rosserial_python.servers import Servers
from pyros1.robot_nodes.shared.parameters import PrivateParameters, is_number
from pyros1.robot_nodes.shared.program import run_node

DEFAULT_PORT = "/dev/ttyUSB0"
DEFAULT_BAUD = 57600
DEFAULT_TCP_PORT = 11411
RETRY_PERIOD = 1.0
"""Seconds between attempts to open a port."""
MAX_BOARDS = 32
_STOCK_NAMESPACE = "/rosserial_embeddedlinux"


class SerialNode:
    """Connects boards until the node shuts down.

    Args:
        node: the node that has the boards' topics and services.
        args: the command line's arguments, without remappings and the program's name.

    Raises:
        SettingError: an argument is not valid.
        NodeError: the TCP port is in use.
    """

    def __init__(self, node: Node, args: list[str]) -> None:
        self._node = node
        self._boards: list[Board] = []
        self._servers = Servers()
        self._stopping = threading.Event()
        params = PrivateParameters.of(node)
        port = args[0] if args else params.text("port", DEFAULT_PORT)  # as in stock ROS, the argument takes precedence
        second = _parse_number(args[1]) if len(args) > 1 else None
        if port == "tcp":
            run = self._prepare_tcp(params, second)
        else:
            # Unlike stock, accept a speed on the command line, as users expect; the parameter takes precedence.
            baud = _read_speed(params, second or DEFAULT_BAUD)
            run = partial(self._run_serial, port, baud)
        self._diagnostics = node.advertise("/diagnostics", DiagnosticArray, queue_size=10)
        node.timer(1.0, lambda event: self._publish_diagnostics())
        self._thread = threading.Thread(target=run, name=f"{node.name}:boards", daemon=True)
        self._thread.start()
        node.on_shutdown(self._stop)

    def _stop(self) -> None:
        self._stopping.set()
        self._thread.join(3.0)

    # A serial line ----------------------------------------------------------------------------------------------------

    def _run_serial(self, name: str, baud: int) -> None:
        hint = f"is ~baud={baud} the speed in the board's program? Is its rosserial of version 0.5 or newer?"
        board = self._add_board(name, hint)
        said = ""
        while not self._stopping.is_set():
            try:
                with closing(SerialPort(name, baud)) as port:
                    self._node.log.info("Connected to %s at %d baud", name, baud)
                    said = ""
                    board.run(port)
            except PortError as error:
                board.set_problem(str(error))
                if str(error) != said:
                    self._node.log.error("%s; trying again every %g s", error, RETRY_PERIOD)
                    said = str(error)
            self._stopping.wait(RETRY_PERIOD)
        self._remove_board(board)

    # TCP --------------------------------------------------------------------------------------------------------------

    def _prepare_tcp(self, params: PrivateParameters, port: int | None) -> Any:
        get = self._node.params.get
        fallback = get(f"{_STOCK_NAMESPACE}/tcp_port", DEFAULT_TCP_PORT)
        port = port or params.integer("tcp_port", int(fallback) if is_number(fallback) else DEFAULT_TCP_PORT, 0, 65535)
        several = params.flag("fork_server", get(f"{_STOCK_NAMESPACE}/fork_server", False) is True)
        try:
            listener = listening_socket("0.0.0.0", port)
        except OSError as error:
            raise SettingError(f"cannot listen on port {port}: {error.strerror}; choose another by ~tcp_port") from None
        self.tcp_port = listener.getsockname()[1]
        listener.settimeout(0.25)
        self._node.log.info("Waiting for socket connections on port %d", self.tcp_port)
        return partial(self._run_tcp, listener, several)

    def _run_tcp(self, listener: socket.socket, several: bool) -> None:
        threads: list[threading.Thread] = []
        with listener:
            while not self._stopping.is_set():
                try:
                    sock, address = listener.accept()
                except TimeoutError:
                    continue
                except OSError as error:  # for example, too many open files
                    self._node.log.error("cannot accept connections: %s", error, throttle=60)
                    self._stopping.wait(RETRY_PERIOD)
                    continue
                port = TcpPort(sock, f"the board at {address[0]}")
                threads = [thread for thread in threads if thread.is_alive()]
                if not several:
                    self._serve(port, address[0])
                elif len(threads) < MAX_BOARDS:
                    serve = partial(self._serve, port, address[0])
                    threads.append(threading.Thread(target=serve, name=f"{self._node.name}:board", daemon=True))
                    threads[-1].start()
                else:
                    text = "the board at %s is refused: %s are connected"
                    self._node.log.peer_event(ERROR, text, address[0], MAX_BOARDS)
                    port.close()
        for thread in threads:
            thread.join(2.0)

    def _serve(self, port: Port, name: str) -> None:
        self._node.log.peer_event(INFO, "Established a socket connection from %s", name)
        board = self._add_board(name, "is it a rosserial program of version 0.5 or newer?")
        try:
            with closing(port):
                board.run(port, end_if_lost=True)
        except PortError as error:
            self._node.log.peer_event(WARN, "%s", error)
        finally:
            self._remove_board(board)

    # Boards -----------------------------------------------------------------------------------------------------------

    def _add_board(self, name: str, hint: str) -> Board:
        board = Board(self._node, name, hint, self._publish_diagnostics, self._servers)
        self._boards.append(board)
        return board

    def _remove_board(self, board: Board) -> None:
        self._boards.remove(board)
        board.close()

    def _publish_diagnostics(self) -> None:
        array = DiagnosticArray(status=[board.status() for board in tuple(self._boards)])
        array.header.stamp = self._node.now()
        if array.status and not self._stopping.is_set():
            self._diagnostics.publish(array)


def _read_speed(params: PrivateParameters, default: int) -> int:
    value = params.value("baud")
    if isinstance(value, str) and value.isascii() and value.isdigit() and int(value[:10]):
        return int(value[:10])  # as in stock ROS, it may be a string
    return params.integer("baud", default, 1, 2**31)


def _parse_number(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 10 and 0 < int(text[:10]) < 2**31):
        raise SettingError(f"{text!r} is not a number: serial_node.py [PORT [BAUD]], or serial_node.py tcp [TCP_PORT]")
    return int(text)


def main(argv: list[str]) -> int:
    """Run serial_node.py; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    args = [arg for arg in argv[1:] if ":=" not in arg]
    return run_node(argv, "serial_node", lambda node: SerialNode(node, args))


if __name__ == "__main__":
    sys.exit(main(sys.argv))
