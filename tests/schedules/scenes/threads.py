"""Parts that hand work from thread to thread: workers, the writer of logs, the callback queue, watches, services."""

from __future__ import annotations

import contextlib
import struct
from typing import Any

from pyros1.msgs.std_srvs.srv import SetBool
from pyros1.net.background_writer import BackgroundWriter
from pyros1.node.callback_queue import CallbackQueue
from pyros1.node.publishing.peers import PeerWatch
from pyros1.node.services.server import ServiceServer, service_type
from pyros1.node.services.workers import Workers
from pyros1.wire.handshake import Refusal, make_service_client_header
from pyros1.wire.header import HeaderReader

from ..network import Socket
from ..stage import Scenario, Stage
from .lanes import check_order
from .parts import DATA, PUBLISHING, Reader, end_context, make_context, make_publication

THREADS, JOBS = 3, 2


class Working(Scenario):
    """Jobs for workers that end when they have been idle for a moment: each is done once, or refused."""

    modules = ("pyros1.node.services.workers",)
    limits = (("pyros1.node.services.workers", "IDLE_TIMEOUT", 30e-6),)

    def play(self, stage: Stage) -> None:
        """Play it."""
        workers = Workers("worker", 2)
        done: list[tuple[int, int]] = []
        accepted: list[tuple[int, int]] = []

        def bring(thread: int) -> Any:
            def submit() -> None:
                for number in range(JOBS):
                    item = (thread, number)
                    if workers.submit(lambda item=item: done.append(item)):  # type: ignore[misc]
                        accepted.append(item)

            return submit

        stage.together(*(bring(thread) for thread in range(THREADS)))
        stage.until(lambda: sorted(done) == sorted(accepted), 5.0)
        assert accepted
        workers.close()
        assert not workers.submit(lambda: None)


class Writing(Scenario):
    """Lines for a writer whose thread ends when it has nothing to do: each is written once, in order."""

    modules = ("pyros1.net.background_writer", "pyros1.net.signal_safe")
    limits = (
        ("pyros1.net.background_writer", "IDLE_TIMEOUT", 50e-6),
        ("pyros1.net.background_writer", "WRITE_INTERVAL", 20e-6),
    )

    def play(self, stage: Stage) -> None:
        """Play it."""
        written: list[tuple[int, int]] = []

        def put(items: list[tuple[str, str]], _give_up: object) -> None:
            for _, text in items:
                thread, number = text.split()
                written.append((int(thread), int(number)))

        writer = BackgroundWriter("log", put)

        def write(thread: int) -> Any:
            def job() -> None:
                for number in range(JOBS):
                    writer.write("", f"{thread} {number}")
                    writer.flush(10.0)
                    assert (thread, number) in written, "flush came back before the line was written"

            return job

        stage.together(*(write(thread) for thread in range(THREADS)))
        writer.close()
        check_order(written, THREADS, JOBS)


class Calling(Scenario):
    """Callbacks for two threads that spin: each is called once."""

    modules = ("pyros1.node.callback_queue", "pyros1.net.signal_safe")

    def play(self, stage: Stage) -> None:
        """Play it."""
        queue = CallbackQueue()
        called: list[tuple[int, int]] = []

        def spin() -> None:
            while len(called) < THREADS * JOBS:
                queue.wait(60.0)
                queue.run_available()
            queue.wake()

        def push(thread: int) -> Any:
            def job() -> None:
                for number in range(JOBS):
                    queue.push(lambda item=(thread, number): called.append(item))  # type: ignore[misc]

            return job

        stage.together(spin, spin, *(push(thread) for thread in range(THREADS)))
        assert sorted(called) == [(thread, number) for thread in range(THREADS) for number in range(JOBS)], called
        assert not len(queue)


class Watching(Scenario):
    """Who watches is told of subscribers that come and go: of each once, first that it came."""

    modules = (*PUBLISHING, "pyros1.node.publishing.peers", "pyros1.node.watching.notifiers")

    def play(self, stage: Stage) -> None:
        """Play it."""
        context = make_context(stage, "/talker")
        publication = make_publication(context, 0)
        told: list[tuple[str, str]] = []
        watch = PeerWatch(
            publication,
            lambda peer: told.append(("came", peer.name)),
            lambda peer: told.append(("went", peer.name)),
            context.log,
        )
        readers = [Reader(stage, most=most, name=f"/reader{most}") for most in (1, 200, None)]
        threads = stage.spawn(*(reader.read for reader in readers))
        stage.together(*(lambda reader=reader: reader.link(publication) for reader in readers))  # type: ignore[misc]
        stage.until(lambda: readers[2].data)
        publication.close(stage.time.monotonic() + 500.0)
        stage.until(lambda: not publication.links)
        for thread in threads:
            thread.join()
        stage.until(lambda: sum(what == "went" for what, _ in told) == sum(what == "came" for what, _ in told))
        for name in {name for _, name in told}:
            assert [what for what, other in told if other == name] == ["came", "went"], told
        watch.close()
        end_context(context)


class Serving(Scenario):
    """Calls of a service that shuts down meanwhile: each is answered rightly, or its connection ends."""

    modules = (
        *DATA,
        "pyros1.node.services.server",
        "pyros1.node.services.client_connection",
        "pyros1.node.services.workers",
        "pyros1.wire.framing",
    )
    limits = (
        ("pyros1.node.services.client_connection", "LINGER_TIME", 1e-3),
        ("pyros1.node.services.workers", "IDLE_TIMEOUT", 1e-3),
    )

    def play(self, stage: Stage) -> None:
        """Play it."""
        context = make_context(stage, "/server")
        workers = Workers("worker")
        server = ServiceServer(
            context, workers, "/s", "rosrpc://", SetBool, lambda request: (request.data, "x"), lambda each: each.close()
        )
        answers: list[bytes] = []

        def client(persistent: bool) -> Any:
            near, far = stage.network.pair()

            def call() -> None:
                near.setblocking(False)
                header = make_service_client_header("/client", "/s", service_type(SetBool), persistent, {})
                context.loop.call_soon(self.accept, server, near, header)
                with far:
                    greet(far)
                    for _ in range(3 if persistent else 1):
                        with contextlib.suppress(ConnectionError):
                            far.sendall(struct.pack("<IB", 1, 1))
                        answer = receive(far, 11)
                        if not answer:
                            return
                        answers.append(answer)

            return call

        def shut_down() -> None:
            stage.until(lambda: answers)
            server.shutdown()

        stage.together(client(True), client(False), shut_down)
        context.stopping.set()
        workers.close()
        end_context(context)
        assert set(answers) == {struct.pack("<BIBIc", 1, 6, 1, 1, b"x")}, answers

    def accept(self, server: ServiceServer, sock: Socket, header: dict[str, str]) -> None:
        """Do what a node's server does with a connection. On the loop."""
        try:
            server.accept(sock, header, b"")  # type: ignore[arg-type]
        except Refusal:
            sock.close()


def greet(sock: Socket) -> None:
    """Read the header of the other side; all of it, or nothing."""
    reader = HeaderReader()
    while data := receive(sock, 1):
        if reader.feed(data) is not None:
            return


def receive(sock: Socket, size: int) -> bytes:
    """Return that many bytes, or none if the connection ends before."""
    data = b""
    while len(data) < size:
        try:
            more = sock.recv(size - len(data))
        except ConnectionError:
            more = b""
        if not more:
            assert not data, f"a torn answer: {data!r}"
            return b""
        data += more
    return data
