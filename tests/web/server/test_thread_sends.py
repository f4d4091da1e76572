"""Clients at the server's port, to which the threads that receive messages send them."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import cbor2
import pytest
from serving import PATIENCE, Served
from websockets.exceptions import ConnectionClosedError
from websockets.sync.client import ClientConnection, connect

from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.web.rosbridge import client as client_module
from pyros1.web.server.shared_transport import SharedTransport

Connect = Callable[..., ClientConnection]
MEGABYTE = 1 << 20


@pytest.fixture
def join(serve: Callable[..., Served]) -> Iterator[Connect]:
    """Return a function that connects a client, and subscribes it to a topic in a form."""
    server = serve(token="")
    with ExitStack() as stack:

        def connect_and_subscribe(form: str, **options: Any) -> ClientConnection:
            url = f"ws://localhost:{server.port}/"
            client = stack.enter_context(connect(url, open_timeout=PATIENCE, max_size=None, **options))
            client.send(json.dumps({"op": "subscribe", "topic": "/images", "compression": form}))
            client.send(json.dumps({"op": "unadvertise_service", "service": "none", "id": "settled"}))
            assert json.loads(client.recv(timeout=PATIENCE))["id"] == "settled"
            return client

        yield connect_and_subscribe


def width(client: ClientConnection) -> int:
    """Return the number that is in the next message, and check that its array is whole."""
    message = cbor2.loads(client.recv(timeout=PATIENCE))["msg"]
    number: int = message["width"]
    assert message["data"] == bytes((number,)) * MEGABYTE
    return number


def test_a_client_that_does_not_read_keeps_nobody_waiting(join: Connect, make_node: Callable[..., Any]) -> None:
    """It gets the newest messages when it reads again, each whole and in order."""
    publisher = make_node("camera").advertise("images", Image)
    slow, other = join("cbor", max_queue=1), join("cbor")
    numbers = range(40)
    for number in numbers:
        publisher.publish(Image(width=number, data=bytes((number,)) * MEGABYTE))
        assert width(other) == number
    found = [width(slow)]
    while found[-1] != numbers[-1]:
        found.append(width(slow))
    assert found == sorted({*found})
    assert len(found) < len(numbers), "nothing was dropped: this test needs more messages"


def test_a_fault_while_a_message_is_encoded(
    join: Connect, make_node: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The topic's other clients may not notice; this client's connection ends."""
    encode = client_module.encode_message

    def fail_for_one(arrival: Any, form: str, topic: str) -> Any:
        if form == "cbor-raw":
            raise ZeroDivisionError
        return encode(arrival, form, topic)

    monkeypatch.setattr(client_module, "encode_message", fail_for_one)
    publisher = make_node("camera").advertise("images", Image)
    faulty, other = join("cbor-raw"), join("cbor")
    publisher.publish(Image(width=1, data=b"\x01" * MEGABYTE))
    assert width(other) == 1
    with pytest.raises(ConnectionClosedError) as caught:
        faulty.recv(timeout=PATIENCE)
    assert caught.value.rcvd is not None and caught.value.rcvd.code == 1011
    publisher.publish(Image(width=2, data=b"\x02" * MEGABYTE))
    assert width(other) == 2


def test_frames_are_not_compressed(join: Connect) -> None:
    """They do not pass through the library, which would compress them."""
    client = join("none", compression="deflate")
    assert client.request is not None and "permessage-deflate" in client.request.headers["Sec-WebSocket-Extensions"]
    assert client.response is not None and "Sec-WebSocket-Extensions" not in client.response.headers


def test_the_socket_of_a_connection_that_has_ended_is_closed(join: Connect, monkeypatch: pytest.MonkeyPatch) -> None:
    """Threads have a descriptor of their own, with which the connection would stay half open."""
    ended = threading.Event()
    shared: list[SharedTransport] = []
    share, lose = SharedTransport.share, SharedTransport.lose

    def note_start(transport: SharedTransport) -> None:
        share(transport)
        shared.append(transport)

    def note_end(transport: SharedTransport) -> None:
        lose(transport)
        ended.set()

    monkeypatch.setattr(SharedTransport, "share", note_start)
    monkeypatch.setattr(SharedTransport, "lose", note_end)
    client = join("none")
    duplicate = shared[0].socket
    assert duplicate is not None and duplicate.fileno() >= 0
    client.close()
    assert ended.wait(PATIENCE)
    assert duplicate.fileno() == -1
