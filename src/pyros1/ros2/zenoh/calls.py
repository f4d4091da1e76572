"""Service calls over zenoh, as rmw_zenoh makes them: a call is a query, and its response is a reply to it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from pyros1.bridge.transport.zenoh_link import MAX_PACKET
from pyros1.ground.errors import ServiceRefusal
from pyros1.ground.terminal_text import one_line
from pyros1.ros2.zenoh.attachments import Attachment, decode_attachment, encode_attachment
from pyros1.ros2.zenoh.names import DataKey, data_key

if TYPE_CHECKING:
    import zenoh

_MAX_ATTACHMENT = 1000
_MAX_ERROR = 1000


class IncomingCall:
    """A call from a client in ROS 2. The receiver must end it with one of its methods.

    Args:
        key: the key of the service.
        query: zenoh's query.

    Attributes:
        key: the key of the service.
        body: the encoded request; empty if it is not valid.
        origin: the attachment of the request; None if the call is not from a ROS 2 node, and must be dropped.
    """

    def __init__(self, key: DataKey, query: zenoh.Query) -> None:
        self.key = key
        self.body = b""
        self.origin: Attachment | None = None
        self._query: Any = query
        payload, attachment = query.payload, query.attachment
        if payload is None or attachment is None or str(query.key_expr) != data_key(key):
            return
        if len(attachment) < _MAX_ATTACHMENT and len(payload) <= MAX_PACKET:
            self.origin = decode_attachment(attachment.to_bytes())
            self.body = payload.to_bytes()

    def respond(self, body: bytes) -> None:
        """Send the encoded response.

        Raises:
            Exception: an error of any type from zenoh, if the session has been closed.
        """
        assert self.origin is not None
        attachment = encode_attachment(self.origin._replace(source_time=time.time_ns()))
        try:
            self._query.reply(data_key(self.key), body, attachment=attachment)
        finally:
            self.drop()

    def fail(self, text: str) -> None:
        """Tell the client why there will be no response. ROS 2 services cannot return errors: rmw_zenoh logs the text,
        and its client keeps waiting.
        """
        with suppress(Exception):  # errors from zenoh, if the session has been closed
            self._query.reply_err(text.encode("utf-8", "replace")[:_MAX_ERROR])
        self.drop()

    def drop(self) -> None:
        """End the call without a reply."""
        self._query.drop()


class LaterReply:
    """Passes on the first reply to a call, and ignores any others.

    Args:
        done: called once, on any thread, with the encoded response or the reason why there is none. It must return at
            once.
    """

    def __init__(self, done: Callable[[bytes | ServiceRefusal], object]) -> None:
        self._done: Callable[[bytes | ServiceRefusal], object] | None = done
        self._lock = threading.Lock()

    @property
    def is_done(self) -> bool:
        """Whether `done` has been called."""
        return self._done is None

    def put(self, reply: zenoh.Reply | None) -> None:
        """Handle a reply, or None, which means that there are no more."""
        with self._lock:
            done, self._done = self._done, None
        if done is not None:
            try:
                response: bytes | ServiceRefusal = response_of(reply)
            except ServiceRefusal as error:
                response = error
            done(response)

    def withdraw(self) -> bool:
        """Pass on nothing from now on; return whether nothing had been passed on yet."""
        with self._lock:
            done, self._done = self._done, None
        return done is not None


def response_of(reply: zenoh.Reply | None) -> bytes:
    """Return the encoded response in a reply.

    Args:
        reply: the first reply to a call; None if there was none.

    Raises:
        ServiceRefusal: there was none, or it is an error.
    """
    if reply is None:
        raise ServiceRefusal("the service in ROS 2 does not respond")
    if reply.ok is None:
        text = "" if reply.err is None else reply.err.payload.to_bytes()[:_MAX_ERROR].decode("utf-8", "replace")
        raise ServiceRefusal(f"the service in ROS 2 does not respond: {one_line(text, _MAX_ERROR)}")
    return bytes(reply.ok.payload.to_bytes())
