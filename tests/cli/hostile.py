"""A robot whose every text would steer the terminal of whoever looks at it."""

from __future__ import annotations

import contextlib
import re
import socket
import threading
from typing import Any

from pyros1.msgs import load_message
from pyros1.net.loop import Loop
from pyros1.net.xmlrpc_server import XmlRpcServer
from pyros1.wire.header import HeaderReader, encode_header

from ..bodies import encode

BAD = "\x9b31m\u202e\u2066\x85\u2028\x7f\nFORGED line\n\tFORGED\x9d0;title\x9c"
"""What XML-RPC can carry: a C1 control sequence, marks of direction, line breaks."""
WORSE = BAD + "\x1b[2J\x1b]0;title\x07\r\x00"
"""What bytes can carry besides."""
_CONTROL = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ufeff]")

String: Any = load_message("std_msgs/String")


def assert_clean(text: str, where: object = "") -> None:
    """Fail if a control character came through, or a line break that let a text pass for a line of ours."""
    found = _CONTROL.search(text)
    assert found is None, f"{where}: {found.group()!r} in {text!r}"
    if "echo" in str(where) and " -p " in str(where):
        return  # rows of values hold strings as they are, line breaks too, as stock's
    forged = [line for line in text.splitlines() if line.startswith(("FORGED", "\tFORGED"))]
    assert not forged, f"{where}: {text!r}"


class HostileRobot:
    """A master, a node and a TCPROS port.

    Args:
        mode: "answer" answers everything, "fail" and "wrong" answer with status 0 and -1, "fault" with XML-RPC faults,
            "refuse" answers but refuses connections.
    """

    def __init__(self, mode: str = "answer") -> None:
        self._mode = mode
        self._loop = Loop("hostile")
        self._server = XmlRpcServer(self._loop, self._dispatch, bind_host="127.0.0.1", advertised_host="localhost")
        self.uri = self._server.uri
        self._loop.start()
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self._socks: list[socket.socket] = []
        self._thread = threading.Thread(target=self._serve, name="hostile", daemon=True)
        self._thread.start()

    def close(self) -> None:
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._thread.join(5)
        for sock in self._socks:
            sock.close()
        self._server.close()
        self._loop.stop()

    def _dispatch(self, method: str, params: Any) -> Any:
        from pyros1.ground.errors import XmlRpcFault

        if self._mode == "fault":
            raise XmlRpcFault(1, BAD)
        if self._mode in ("fail", "wrong") and method != "getPid":
            return [0 if self._mode == "fail" else -1, BAD, 0]
        topics, nodes, services = ["/topic", "/topic" + BAD], ["/node", "/node" + BAD], ["/service", "/service" + BAD]
        answers: dict[str, Any] = {
            "getPid": 1,
            "getUri": self.uri,
            "getSystemState": [[[name, nodes] for name in table] for table in (topics, topics, services)],
            "getTopicTypes": [["/topic", "std_msgs/String"], ["/topic" + BAD, "std_msgs/Bad" + BAD]],
            "getPublishedTopics": [["/topic", "std_msgs/String"], ["/topic" + BAD, "std_msgs/Bad" + BAD]],
            "lookupNode": self.uri,
            "lookupService": f"rosrpc://localhost:{self.port}",
            "registerSubscriber": [self.uri],
            "registerPublisher": [],
            "unregisterSubscriber": 1,
            "unregisterPublisher": 1,
            "registerService": 1,
            "unregisterService": 1,
            "subscribeParam": {},
            "unsubscribeParam": 1,
            "setParam": 0,
            "deleteParam": 0,
            "getParamNames": ["/p", "/p" + BAD],
            "getParam": self._parameter(str(params[-1]) if params else ""),
            "hasParam": True,
            "searchParam": "/p" + BAD,
            "getBusInfo": [
                [
                    1,
                    "/peer" + BAD,
                    "o",
                    "TCPROS" + BAD,
                    "/topic" + BAD,
                    True,
                    f"TCPROS connection on port 1 to [{BAD}:1]",
                ],
                [2, self.uri, "i", "TCPROS", "/topic", True, "TCPROS connection on port 1 to [h\x9b:1 on socket 2]"],
                [3, "http://h" + BAD, "i", "TCPROS", "/topic", False],
            ],
            "getBusStats": [[], [], []],
            "getSubscriptions": [["/topic" + BAD, "std_msgs/Bad" + BAD], ["/topic", "*"]],
            "getPublications": [["/topic" + BAD, "std_msgs/Bad" + BAD]],
            "requestTopic": ["TCPROS", "localhost", self.port],
            "publisherUpdate": 0,
            "shutdown": 0,
            "getName": "/node" + BAD,
            "getMasterUri": self.uri,
        }
        if method not in answers:
            raise XmlRpcFault(1, f"no method {method}{BAD}")
        return [1, BAD, answers[method]]

    @staticmethod
    def _parameter(name: str) -> Any:
        if name in ("/use_sim_time", "/run_id", "/rosdistro", "/rosversion"):
            return name != "/use_sim_time" and BAD
        if name == "/p":
            return BAD
        return {"key" + BAD: "value" + BAD, "list": [BAD, {"deep" + BAD: BAD}], "n": 1}

    def _serve(self) -> None:
        while True:
            try:
                sock, _ = self._listener.accept()
            except OSError:
                return
            self._socks.append(sock)
            sock.settimeout(5)
            with contextlib.suppress(OSError):
                self._greet(sock)

    def _greet(self, sock: socket.socket) -> None:
        reader, header = HeaderReader(), None
        while header is None:
            data = sock.recv(65536)
            if not data:
                return
            header = reader.feed(data)
        if self._mode == "refuse":
            sock.sendall(encode_header({"error": "no" + WORSE}))
            sock.close()
            return
        answer = {"callerid": "/node" + WORSE, "extra" + BAD.replace("=", ""): WORSE}
        if "service" in header:
            kind = "std_srvs/Trigger"
            answer |= {"service": header["service"], "type": kind, "request_type": kind + WORSE, "response_type": kind}
            sock.sendall(encode_header({**answer, "md5sum": "937c9679a518e3a18d831e57125ea522"}))
            if header.get("probe") != "1":
                text = ("failed" + WORSE).encode()
                sock.sendall(b"\0" + len(text).to_bytes(4, "little") + text)
            return
        answer |= {"type": "std_msgs/String", "md5sum": String._md5sum, "topic": "/topic", "latching": "1"}
        sock.sendall(encode_header({**answer, "message_definition": "string data # " + WORSE.replace("\n", " ")}))
        body = encode(String("data" + WORSE))
        for _ in range(3):
            sock.sendall(len(body).to_bytes(4, "little") + body)
