"""The Python peers of the interop tests: what rospy_peer.py and pyros1_peer.py have in common.

A peer does what the lines on its standard input say and prints one line per event; ``interop/README.md`` lists the
commands. A backend is the thin layer over one client library.
"""

from __future__ import annotations

import io
import os
import queue
import sys
import threading
import time
import zlib
from collections.abc import Callable
from typing import Any

from samples import PARAMETERS, REQUESTS, TYPES, Samples, reply, show

DEADLINE = 25.0  # seconds, for the commands that wait

_print_lock = threading.Lock()


def say(*words: object) -> None:
    """Print one event line at once; callbacks run on many threads."""
    line = " ".join(str(word) for word in words) + "\n"
    with _print_lock:
        sys.stdout.buffer.write(line.encode("utf-8", "surrogateescape"))
        sys.stdout.buffer.flush()


def show_body(raw: bytes) -> str:
    """A serialized message as the event lines carry it: hexadecimal, ``-`` when empty, a checksum when long."""
    if len(raw) > 4096:
        return f"#{len(raw)}:{zlib.crc32(raw):08x}"
    return raw.hex() or "-"


def encode(message: Any) -> bytes:
    """Serialize a message with the method that genpy and pyros1 have in common."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


class Handled(Exception):
    """Raised by a service handler on purpose; its text should reach the caller."""


class Backend:
    """What a client library must offer to be a peer. Names are ROS names, types are ``package/Type``."""

    samples: Samples

    def advertise(self, topic: str, type_name: str, queue_size: int, latch: bool) -> Any: ...

    def subscribe(self, topic: str, type_name: str, queue_size: int, callback: Callable[[Any], None]) -> Any: ...

    def links(self, endpoint: Any) -> int: ...

    def serve(self, name: str, type_name: str, handler: Callable[[Any], Any]) -> Any: ...

    def unserve(self, server: Any) -> None: ...

    def new_request(self, type_name: str) -> Any: ...

    def new_response(self, type_name: str) -> Any: ...

    def client(self, name: str, type_name: str, persistent: bool) -> Any: ...

    def available(self, name: str, timeout: float) -> bool: ...

    def set_param(self, key: str, value: Any) -> None: ...

    def get_param(self, key: str) -> Any: ...

    def cached_param(self, key: str) -> Any: ...

    def has_param(self, key: str) -> bool: ...

    def delete_param(self, key: str) -> bool: ...

    def search_param(self, key: str) -> str | None: ...

    def log(self, level: str, text: str) -> None: ...

    def close(self) -> None: ...


UNSET = object()


class Peer:
    """Runs commands on a backend. Every command is a method ``do_<verb>`` that takes the words after the verb."""

    def __init__(self, backend: Backend) -> None:
        self.backend = backend
        self.publishers: dict[str, tuple[str, Any]] = {}
        self.subscribers: dict[str, Any] = {}
        self.headers: dict[str, dict[str, str]] = {}
        self.servers: dict[str, Any] = {}
        self.clients: dict[str, Any] = {}

    def run(self, name: str, commands: queue.Queue[str | None]) -> None:
        """Obey commands until ``quit``, end of input or the node's shutdown (None)."""
        say("ready", name)
        while True:
            try:
                line = commands.get(timeout=0.2)  # Python may overlook a signal that comes just before a wait
            except queue.Empty:
                continue
            if line is None or line == "quit":
                break
            verb, *words = line.split(" ")
            try:
                getattr(self, "do_" + verb)(*words)
            except Exception as problem:  # noqa: BLE001  whatever happens, the test must read it
                say("error", line + ":", type(problem).__name__, " ".join(str(problem).split()))
        self.backend.close()
        say("bye")

    def do_pub(self, topic: str, type_name: str, queue_size: str, latch: str) -> None:
        self.publishers[topic] = type_name, self.backend.advertise(topic, type_name, int(queue_size), latch == "1")
        say("advertised", topic)

    def do_send(self, topic: str, seed: str) -> None:
        type_name, publisher = self.publishers[topic]
        message = self.backend.samples.build(type_name, int(seed))
        publisher.publish(message)
        say("sent", topic, show_body(encode(message)))

    def do_burst(self, topic: str, first: str, count: str) -> None:
        type_name, publisher = self.publishers[topic]
        for seed in range(int(first), int(first) + int(count)):
            publisher.publish(self.backend.samples.build(type_name, seed))
        say("burst", topic)

    def do_unpub(self, topic: str) -> None:
        self.publishers.pop(topic)[1].unregister()
        say("unadvertised", topic)

    def do_sub(self, topic: str, type_name: str, queue_size: str) -> None:
        def heard(message: Any) -> None:
            self.headers[topic] = dict(message._connection_header)
            say("got", topic, show_body(encode(message)))

        self.subscribers[topic] = self.backend.subscribe(topic, type_name, int(queue_size), heard)
        say("subscribed", topic)

    def do_unsub(self, topic: str) -> None:
        self.subscribers.pop(topic).unregister()
        say("unsubscribed", topic)

    def do_linked(self, topic: str, count: str) -> None:
        endpoint = self.publishers[topic][1] if topic in self.publishers else self.subscribers[topic]
        self._wait(f"linked {topic} {count}", lambda: self.backend.links(endpoint) == int(count))

    def do_header(self, topic: str) -> None:
        header = dict(self.headers[topic])
        if "message_definition" in header:
            header["message_definition"] = f"{zlib.crc32(header['message_definition'].encode()):08x}"
        say("header", topic, *(f"{key}={header[key]}" for key in sorted(header)))

    def do_serve(self, name: str, type_name: str, mode: str) -> None:
        def handle(request: Any) -> Any:
            say("served", name, show_body(encode(request)))
            if mode in ("refuse", "throw"):
                raise Handled("no luck")
            if mode == "die":
                os._exit(9)
            if mode == "hang":
                threading.Event().wait()
            return reply(type_name, request, self.backend.new_response(type_name))

        self.servers[name] = self.backend.serve(name, type_name, handle)
        say("serving", name)

    def do_unserve(self, name: str) -> None:
        self.backend.unserve(self.servers.pop(name))
        say("unserved", name)

    def do_available(self, name: str) -> None:
        say("available" if self.backend.available(name, DEADLINE) else "timeout available", name)

    def do_call(self, name: str, type_name: str, seed: str, persistent: str) -> None:
        request = self.backend.new_request(type_name)
        REQUESTS[type_name](self.backend.samples, request, int(seed))
        client = self.clients.get(name) if persistent == "1" else None
        if client is None:
            client = self.backend.client(name, type_name, persistent == "1")
            if persistent == "1":
                self.clients[name] = client
        say("called", name, show_body(encode(request)))
        try:
            response = client(request)
        except Exception as problem:  # noqa: BLE001  each library has its own errors; the test reads them
            say("failed", name, type(problem).__name__, " ".join(str(problem).split()))
        else:
            say("answer", name, show_body(encode(response)))

    def do_hangup(self, name: str) -> None:
        self.clients.pop(name).close()
        say("hung", name)

    def do_setparam(self, key: str, sample: str) -> None:
        self.backend.set_param(key, PARAMETERS[sample])
        say("set", key)

    def do_getparam(self, key: str) -> None:
        value = self.backend.get_param(key)
        say("getparam", key, "unset" if value is UNSET else show(value))

    def do_cachedparam(self, key: str) -> None:
        value = self.backend.cached_param(key)
        say("cachedparam", key, "unset" if value is UNSET else show(value))

    def do_hasparam(self, key: str) -> None:
        say("hasparam", key, int(self.backend.has_param(key)))

    def do_delparam(self, key: str) -> None:
        say("delparam", key, int(self.backend.delete_param(key)))

    def do_searchparam(self, key: str) -> None:
        say("searchparam", key, self.backend.search_param(key) or "none")

    def do_log(self, level: str, *text: str) -> None:
        self.backend.log(level, " ".join(text))
        say("logged", level)

    def do_sample(self, type_name: str, seed: str) -> None:
        message = self.backend.samples.build(type_name, int(seed))
        say("sample", type_name, show_body(encode(message)))

    def do_types(self) -> None:
        say("types", *sorted(TYPES))

    def _wait(self, what: str, reached: Callable[[], bool]) -> None:
        end = time.monotonic() + DEADLINE
        while not reached():
            if time.monotonic() > end:
                say("timeout", what)
                return
            time.sleep(0.005)
        say(what)


def read_commands() -> queue.Queue[str | None]:
    """The lines of standard input as they come, and None at its end; whoever may also end the peer puts a None."""
    commands: queue.Queue[str | None] = queue.Queue()

    def read() -> None:
        for line in sys.stdin:
            commands.put(line.rstrip("\n"))
        commands.put(None)

    threading.Thread(target=read, name="commands", daemon=True).start()
    return commands
