"""Parses and builds HTTP/1.0 and 1.1 messages, to the extent that XML-RPC needs (RFC 9112).

A parser is fed bytes as they arrive and returns complete messages; a connection can carry several, one after the other.
The parser goes through these states::

    HEAD ──> BODY (Content-Length) ───────────────────────────────┐
      ├────> CHUNK_SIZE ──> CHUNK ──> CHUNK_SIZE ... ──> TRAILER ──┤──> a message, then HEAD again
      └────> UNTIL_EOF (a response without length) ─── eof() ──────┘

After an error, a parser cannot be used any more: it is unknown where the next message begins, so the connection must be
closed.
"""

from __future__ import annotations

import re
from enum import Enum, auto
from typing import Final, Generic, NamedTuple, TypeVar

from pyros1.wire.http_head import HttpError, split_head, stays_open

__all__ = [
    "HttpError",
    "HttpLimits",
    "Request",
    "RequestParser",
    "Response",
    "ResponseParser",
    "build_request",
    "build_response",
]


class HttpLimits(NamedTuple):
    """Limits on what a peer may send.

    Attributes:
        head: maximum total size in bytes of the first line and all header fields.
        body: maximum size of a body in bytes.
    """

    head: int = 16 * 1024
    body: int = 32 * 1024 * 1024


class Request:
    """A request. ``keep_alive``: whether the connection stays open after the response; ``is_from_page``: whether a web
    page sent it.
    """

    __slots__ = ("body", "is_from_page", "keep_alive", "method", "path")

    def __init__(self, method: str, path: str, keep_alive: bool, is_from_page: bool = False) -> None:
        self.method = method
        self.path = path
        self.keep_alive = keep_alive
        self.is_from_page = is_from_page
        self.body = b""


class Response:
    """A response. ``keep_alive``: whether the connection can be reused."""

    __slots__ = ("body", "keep_alive", "reason", "status")

    def __init__(self, status: int, reason: str, keep_alive: bool) -> None:
        self.status = status
        self.reason = reason
        self.keep_alive = keep_alive
        self.body = b""


_REQUEST_LINE: Final = re.compile(r"([!#-'*+.^_`|~\w-]{1,32}) (\S+) HTTP/1\.([01])\Z", re.ASCII)
_STATUS_LINE: Final = re.compile(r"HTTP/1\.([01]) ([1-9][0-9][0-9])(?: (.*))?\Z")
_PLAIN_LENGTH: Final = re.compile(rb"\n[Cc]ontent-[Ll]ength: ([0-9]{1,18})")
_CHUNK_LINE_LIMIT: Final = 256

MessageT = TypeVar("MessageT", Request, Response)


class _State(Enum):
    HEAD = auto()
    BODY = auto()
    CHUNK_SIZE = auto()
    CHUNK = auto()
    TRAILER = auto()
    UNTIL_EOF = auto()
    DEAD = auto()


class _Parser(Generic[MessageT]):
    """Base of the parsers of requests and responses."""

    def __init__(self, limits: HttpLimits = HttpLimits()) -> None:  # noqa: B008 - immutable
        self._limits = limits
        self._buffer = bytearray()
        self._searched_size = 0
        self._state = _State.HEAD
        self._message: MessageT | None = None
        self._template_shape = b""
        self._template: MessageT | None = None
        self._expected_size = 0
        self._chunked_body = bytearray()

    @property
    def num_buffered(self) -> int:
        """Number of bytes of an incomplete message that have arrived so far."""
        return len(self._buffer) + len(self._chunked_body)

    @property
    def in_message(self) -> bool:
        """Whether a message has started but is not complete."""
        return bool(self._buffer) or self._state is not _State.HEAD

    def feed(self, data: bytes | bytearray | memoryview) -> None:
        """Add bytes that arrived; call ``next_message`` afterwards."""
        self._buffer += data

    def next_message(self) -> MessageT | None:
        """Return the next complete message, or None if more bytes are needed.

        Raises:
            HttpError: the bytes are not HTTP, or exceed a limit; the parser cannot be used any more.
        """
        try:
            while True:
                previous_state = self._state
                message = self._parse_step()
                if message is not None:
                    return message
                if self._state is previous_state and not (previous_state is _State.HEAD and self._skipped_interim):
                    return None
        except HttpError:
            self._state = _State.DEAD
            self._buffer.clear()
            self._chunked_body.clear()
            raise

    _skipped_interim = False

    def _parse_head(self, first_line: str, headers: dict[str, str]) -> MessageT:
        raise NotImplementedError

    def _copy_template(self, template: MessageT) -> MessageT:
        """Return a new message with the same head as ``template``, without a body."""
        raise NotImplementedError

    def _state_without_length(self) -> _State | None:
        """Return the state for a message with neither a length nor chunks, or None if it has no body."""
        raise NotImplementedError

    def _parse_step(self) -> MessageT | None:  # noqa: PLR0911 - one return per state
        if self._state is _State.HEAD:
            return self._parse_next_head()
        if self._state is _State.BODY:
            if len(self._buffer) < self._expected_size:
                return None
            return self._finish(self._consume(self._expected_size))
        if self._state is _State.CHUNK_SIZE:
            self._read_chunk_size()
            return None
        if self._state is _State.CHUNK:
            self._read_chunk()
            return None
        if self._state is _State.TRAILER:
            return self._skip_trailer()
        if self._state is _State.UNTIL_EOF:
            if len(self._buffer) > self._limits.body:
                raise HttpError(f"an HTTP body of more than {self._limits.body} bytes", 413)
            return None
        raise HttpError("bytes after a malformed HTTP message")

    def _skip_trailer(self) -> MessageT | None:
        """Skip the fields after the last chunk."""
        while True:
            line = self._read_line(self._expected_size)
            if line is None:
                return None
            if not line:
                return self._finish(bytes(self._chunked_body))
            self._expected_size -= len(line)

    def _consume(self, count: int) -> bytes:
        with memoryview(self._buffer) as view:
            consumed = bytes(view[:count])
        del self._buffer[:count]
        return consumed

    def _finish(self, body: bytes) -> MessageT:
        message = self._message
        if message is None:  # cannot happen: only _parse_next_head leaves the state HEAD, and it sets the message
            raise HttpError("an HTTP body without a head")
        message.body = body
        self._message = None
        self._chunked_body = bytearray()
        self._state = _State.HEAD
        self._searched_size = 0
        return message

    def _parse_next_head(self) -> MessageT | None:
        self._skipped_interim = False
        buffer = self._buffer
        # Empty lines before the first line must be ignored (RFC 9112, 2.2).
        while buffer.startswith((b"\r", b"\n")):
            if buffer[:1] == b"\r" and buffer[1:2] not in (b"\n", b""):
                raise HttpError("not an HTTP message")
            if buffer == b"\r":
                return None
            del buffer[: 2 if buffer[:1] == b"\r" else 1]
        size = self._head_size()
        if (len(buffer) if size is None else size) > self._limits.head:
            raise HttpError(f"an HTTP head of more than {self._limits.head} bytes", 431)
        if size is None:
            self._searched_size = len(buffer)
            return None
        head = bytes(buffer[:size])
        del buffer[: size + (2 if buffer[size + 1 : size + 2] == b"\n" else 3)]
        self._searched_size = 0
        # The heads that a peer sends over one connection usually differ only in Content-Length. A parsed head is kept
        # as a template; its shape is the head without the digits of that length.
        length = _PLAIN_LENGTH.search(head)
        shape = head[: length.start(1)] + head[length.end(1) :] if length else b""
        if length and shape == self._template_shape and self._template is not None:
            self._message = self._copy_template(self._template)
            return self._await_body(int(length[1]))
        first_line, headers, is_unambiguous = split_head(head.decode("latin-1"))
        self._message = self._parse_head(first_line, headers)
        return self._choose_body(headers, shape if is_unambiguous else b"")

    def _head_size(self) -> int | None:
        """Return the position of the line feed before the empty line that ends the head, or None if that has not
        arrived.
        """
        buffer = self._buffer
        start = max(0, self._searched_size - 3)
        end = buffer.find(b"\n\r\n", start)
        # The head ends at the first empty line, whichever kind of line break that line has.
        bare_end = buffer.find(b"\n\n", start) if end < 0 else buffer.find(b"\n\n", start, end + 1)
        if bare_end >= 0:
            return bare_end
        return end if end >= 0 else None

    def _choose_body(self, headers: dict[str, str], shape: bytes) -> MessageT | None:
        """Determine how the body ends, and remember the head's shape if all heads of that shape have a length."""
        transfer_coding = headers.get("transfer-encoding")
        length = headers.get("content-length")
        if transfer_coding is not None:
            if length is not None or transfer_coding.lower() != "chunked":
                raise HttpError(f"unsupported Transfer-Encoding {transfer_coding[:40]!r}", 501)
            self._state = _State.CHUNK_SIZE
            return None
        if length is not None:
            if not (length.isascii() and length.isdigit() and len(length) <= 18):
                raise HttpError(f"not a Content-Length: {length[:40]!r}")
            if shape:
                self._template_shape, self._template = shape, self._message
            return self._await_body(int(length))
        state = self._state_without_length()
        if state is None:
            return self._finish(b"")
        self._state = state
        return None

    def _await_body(self, length: int) -> MessageT | None:
        if length > self._limits.body:
            raise HttpError(f"an HTTP body of {length} bytes; the limit is {self._limits.body}", 413)
        if len(self._buffer) >= length:
            return self._finish(self._consume(length))
        self._expected_size = length
        self._state = _State.BODY
        return None

    def _read_line(self, limit: int) -> bytes | None:
        """Return the next line without its line break, or None if it is incomplete."""
        end = self._buffer.find(b"\n")
        if (end if end >= 0 else len(self._buffer)) > limit:
            raise HttpError("an HTTP line that is too long")
        return None if end < 0 else self._consume(end + 1).rstrip(b"\r\n")

    def _read_chunk_size(self) -> None:
        line = self._read_line(_CHUNK_LINE_LIMIT)
        if line is None:
            return
        size = line.split(b";", 1)[0].strip()
        if not re.fullmatch(rb"[0-9A-Fa-f]{1,15}", size):
            raise HttpError(f"not an HTTP chunk size: {size[:20]!r}")
        self._expected_size = int(size, 16)
        if len(self._chunked_body) + self._expected_size > self._limits.body:
            raise HttpError(f"an HTTP body of more than {self._limits.body} bytes", 413)
        if self._expected_size:
            self._state = _State.CHUNK
        else:
            self._expected_size = self._limits.head  # maximum size of the trailer
            self._state = _State.TRAILER

    def _read_chunk(self) -> None:
        # A chunk ends with CRLF or, from lax peers, with LF.
        if len(self._buffer) <= self._expected_size:
            return
        end = bytes(self._buffer[self._expected_size : self._expected_size + 2])
        if end == b"\r":
            return
        if end != b"\r\n" and end[:1] != b"\n":
            raise HttpError("an HTTP chunk longer than announced")
        self._chunked_body += self._consume(self._expected_size)
        del self._buffer[: 2 if end == b"\r\n" else 1]
        self._state = _State.CHUNK_SIZE


class RequestParser(_Parser[Request]):
    """Parses requests. A POST request must have a Content-Length or chunks."""

    def _parse_head(self, first_line: str, headers: dict[str, str]) -> Request:
        match = _REQUEST_LINE.match(first_line)
        if match is None:
            raise HttpError(f"not an HTTP request: {first_line[:40]!r}")
        if match.group(1) == "POST" and "content-length" not in headers and "transfer-encoding" not in headers:
            raise HttpError("a POST request without Content-Length", 411)
        return Request(match.group(1), match.group(2), stays_open(match.group(3), headers), "origin" in headers)

    def _copy_template(self, template: Request) -> Request:
        return Request(template.method, template.path, template.keep_alive, template.is_from_page)

    def _state_without_length(self) -> _State | None:
        return None


class ResponseParser(_Parser[Response]):
    """Parses responses. Interim responses (1xx) are skipped."""

    def _parse_head(self, first_line: str, headers: dict[str, str]) -> Response:
        match = _STATUS_LINE.match(first_line)
        if match is None:
            raise HttpError(f"not an HTTP response: {first_line[:40]!r}")
        return Response(int(match.group(2)), match.group(3) or "", stays_open(match.group(1), headers))

    def _copy_template(self, template: Response) -> Response:
        return Response(template.status, template.reason, template.keep_alive)

    def _choose_body(self, headers: dict[str, str], shape: bytes) -> Response | None:
        message = self._message
        if message is not None and message.status < 200:
            self._message = None
            self._skipped_interim = True
            return None
        if message is not None and message.status in (204, 304):
            return self._finish(b"")
        return super()._choose_body(headers, shape)

    def _state_without_length(self) -> _State | None:
        if self._message is not None:
            self._message.keep_alive = False
        return _State.UNTIL_EOF

    def eof(self) -> Response | None:
        """Process the end of the stream: the peer has closed its side of the connection.

        Returns:
            The response that ends with the stream, or None if no response had started.

        Raises:
            HttpError: a response was cut off.
        """
        if self._state is _State.UNTIL_EOF:
            return self._finish(self._consume(len(self._buffer)))
        if self._state is _State.DEAD or not self.in_message:
            return None
        self._state = _State.DEAD
        raise HttpError("the HTTP response was cut off")


_REASONS: Final = {
    200: "OK",
    400: "Bad Request",
    404: "No such page",
    411: "Length Required",
    413: "Content Too Large",
    431: "Request Header Fields Too Large",
    501: "Unsupported method",
    503: "Service Unavailable",
}


def build_request(host: str, path: str, body: bytes) -> bytes:
    """Return a POST request with an XML body.

    Args:
        host: value of the Host field, ``name:port``.
        path: path of the request, for example ``/``.
    """
    return (
        f"POST {path} HTTP/1.1\r\nHost: {host}\r\nUser-Agent: pyros1\r\nContent-Type: text/xml\r\n"
        f"Content-Length: {len(body)}\r\n\r\n"
    ).encode("latin-1") + body


_COMMON_RESPONSE_HEAD: Final = (
    b"HTTP/1.1 200 OK\r\nServer: pyros1\r\nContent-Type: text/xml\r\n"
    b"Content-Length: %d\r\n%bConnection: keep-alive\r\n\r\n"
)


def build_response(
    status: int, body: bytes, *, keep_alive: bool = True, content_type: str = "text/xml", date: bytes = b""
) -> bytes:
    """Return a response, which also says whether the connection stays open; ``date`` is a line from `date_field`, or
    empty.
    """
    # The Connection field is always sent, since the defaults of HTTP/1.0 and 1.1 clients differ.
    if status == 200 and keep_alive and content_type == "text/xml":
        return _COMMON_RESPONSE_HEAD % (len(body), date) + body
    connection = "keep-alive" if keep_alive else "close"
    return (
        f"HTTP/1.1 {status} {_REASONS.get(status, 'Error')}\r\nServer: pyros1\r\nContent-Type: {content_type}\r\n"
        f"Content-Length: {len(body)}\r\n{date.decode()}Connection: {connection}\r\n\r\n"
    ).encode("latin-1") + body
