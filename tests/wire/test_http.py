"""wire.http: whole messages out of any pieces, and the limits."""

from __future__ import annotations

from collections.abc import Iterable
from email.utils import formatdate
from itertools import pairwise
from time import gmtime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.wire.http import (
    HttpError,
    HttpLimits,
    Request,
    RequestParser,
    Response,
    ResponseParser,
    build_request,
    build_response,
)
from pyros1.wire.http_head import date_field, split_head

CHUNKED = b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n3;x=y\r\nabc\r\n2\r\nde\r\n0\r\nTrailer: a\r\n\r\n"


def requests(pieces: Iterable[bytes], limits: HttpLimits | None = None) -> list[Request]:
    parser = RequestParser(limits or HttpLimits())
    found = []
    for piece in pieces:
        parser.feed(piece)
        while (request := parser.next_message()) is not None:
            found.append(request)
    return found


def one(data: bytes) -> Request:
    (request,) = requests([data])
    return request


def cut(data: bytes, places: list[int]) -> list[bytes]:
    edges = [0, *sorted(place % (len(data) + 1) for place in places), len(data)]
    return [data[a:b] for a, b in pairwise(edges)]


@pytest.mark.slow
@given(st.lists(st.binary(max_size=200), min_size=1, max_size=3), st.lists(st.integers(0, 10_000), max_size=8))
def test_requests_come_out_whole_however_they_are_cut(bodies: list[bytes], places: list[int]) -> None:
    data = b"".join(build_request("h:1", "/", body) for body in bodies) + CHUNKED
    for pieces in ([data], [bytes([byte]) for byte in data], cut(data, places)):
        found = requests(pieces)
        assert [request.body for request in found] == [*bodies, b"abcde"]
        assert all(request.method == "POST" and request.path == "/" and request.keep_alive for request in found)


@given(st.binary(max_size=200), st.lists(st.integers(0, 10_000), max_size=8))
def test_responses_come_out_whole_however_they_are_cut(body: bytes, places: list[int]) -> None:
    data = b"HTTP/1.1 100 Continue\r\n\r\n" + build_response(200, body)
    for pieces in ([data], [bytes([byte]) for byte in data], cut(data, places)):
        parser = ResponseParser()
        found: list[Response] = []
        for piece in pieces:
            parser.feed(piece)
            if (response := parser.next_message()) is not None:
                found.append(response)
        assert [(response.status, response.body) for response in found] == [(200, body)]
        assert not parser.in_message


@given(st.integers(0, 4_102_444_800))  # to the year 2100
def test_dates_are_those_of_http(seconds: int) -> None:
    assert date_field(gmtime(seconds)) == f"Date: {formatdate(seconds, usegmt=True)}\r\n".encode()


@pytest.mark.parametrize(("status", "keep"), [(200, True), (200, False), (404, True)])
def test_a_date_stands_in_the_head(status: int, keep: bool) -> None:
    parser = ResponseParser()
    for second in range(3):  # heads that differ in it
        data = build_response(status, b"abc", keep_alive=keep, date=date_field(gmtime(second)))
        head = split_head(data.split(b"\r\n\r\n")[0].decode())[1]
        assert head["date"] == formatdate(second, usegmt=True) and head["content-length"] == "3"
        parser.feed(data)
        response = parser.next_message()
        assert response is not None and (response.status, response.body, response.keep_alive) == (status, b"abc", keep)


@given(st.binary(max_size=300) | st.binary(max_size=60).map(lambda data: b"POST / HTTP/1.1\r\n" + data + b"\r\n\r\n"))
def test_garbage_gives_messages_or_http_errors(data: bytes) -> None:
    for parser in (RequestParser(HttpLimits(100, 100)), ResponseParser(HttpLimits(100, 100))):
        try:
            parser.feed(data)
            while parser.next_message() is not None:
                pass
            if isinstance(parser, ResponseParser):
                parser.eof()
        except HttpError as error:
            assert 400 <= error.status < 600


@pytest.mark.parametrize(
    ("head", "keep"),
    [
        ("POST / HTTP/1.1\r\n", True),
        ("POST / HTTP/1.1\r\nConnection: close\r\n", False),
        ("POST / HTTP/1.0\r\n", False),
        ("POST / HTTP/1.0\r\nConnection: Keep-Alive\r\n", True),
    ],
)
def test_m01_keep_alive_rules(head: str, keep: bool) -> None:
    assert one(head.encode() + b"Content-Length: 0\r\n\r\n").keep_alive is keep


@pytest.mark.parametrize(
    ("data", "status"),
    [
        (b"nonsense\r\n\r\n", 400),
        (b"POST / HTTP/2.0\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\n\r\n", 411),
        (b"POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nContent-Length: \xb2\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nContent-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n", 501),
        (b"POST / HTTP/1.1\r\nTransfer-Encoding: gzip\r\n\r\n", 501),
        (b"POST / HTTP/1.1\r\nno colon\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nA: b\r\n folded\r\n\r\n", 400),
        (b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nxyz\r\n", 400),
        (b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n1\r\nabc", 400),
        (b"\rPOST", 400),
    ],
)
def test_broken_requests_have_a_status(data: bytes, status: int) -> None:
    with pytest.raises(HttpError) as caught:
        requests([data])
    assert caught.value.status == status


def test_limits_hold_before_anything_is_stored() -> None:
    limits = HttpLimits(head=200, body=10)
    big = b"POST / HTTP/1.1\r\nContent-Length: 999999999999\r\n\r\n"
    chunks = b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n8\r\n12345678\r\n8\r\n"
    trailers = b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n" + b"A: b\r\n" * 100
    for data, status in ((big, 413), (chunks, 413), (b"A" * 300, 431), (trailers, 400)):
        with pytest.raises(HttpError) as caught:
            requests([data], limits)
        assert caught.value.status == status
    parser = ResponseParser(limits)
    parser.feed(b"HTTP/1.0 200 OK\r\n\r\n" + b"x" * 11)
    with pytest.raises(HttpError):
        parser.next_message()


def test_a_dead_parser_stays_dead() -> None:
    parser = RequestParser()
    parser.feed(b"nonsense\r\n\r\n")
    for _ in range(2):
        with pytest.raises(HttpError):
            parser.next_message()
        parser.feed(build_request("h", "/", b""))


def test_a_get_has_no_body_and_bare_line_feeds_are_taken() -> None:
    request = one(b"\r\nGET /x HTTP/1.1\nHost: a\n\n")
    assert (request.method, request.path, request.body) == ("GET", "/x", b"")


def test_a_response_may_end_with_the_connection() -> None:
    parser = ResponseParser()
    parser.feed(b"HTTP/1.0 200 OK\r\n\r\nabc")
    assert parser.next_message() is None
    response = parser.eof()
    assert response is not None
    assert (response.body, response.keep_alive) == (b"abc", False)
    assert ResponseParser().eof() is None


def test_a_cut_off_response_is_an_error() -> None:
    parser = ResponseParser()
    parser.feed(build_response(200, b"abc")[:-1])
    assert parser.next_message() is None
    assert parser.num_buffered == 2
    with pytest.raises(HttpError, match="cut off"):
        parser.eof()


HEADS = [
    "Content-Length: {}",
    "Content-length:  {}",
    "Host: a",
    "Connection: close",
    "X: Content-Length: 3",
    "Transfer-Encoding: chunked",
]


@pytest.mark.slow
@given(
    st.lists(st.lists(st.sampled_from(HEADS), max_size=3), min_size=1, max_size=2),
    st.lists(st.tuples(st.integers(0, 1), st.integers(0, 12)), max_size=6),
)
def test_a_head_is_read_alike_whatever_came_before_it(heads: list[list[str]], order: list[tuple[int, int]]) -> None:
    parsers: list[tuple[RequestParser | ResponseParser, str]] = [
        (RequestParser(), "POST / HTTP/1.1"),
        (ResponseParser(), "HTTP/1.1 200 OK"),
        (ResponseParser(), "HTTP/1.1 204 No"),
    ]
    for parser, first in parsers:
        for which, length in order:
            fields = "".join("\r\n" + field.format(length) for field in heads[which % len(heads)])
            data = f"{first}{fields}\r\n\r\n".encode() + b"." * length
            assert outcome(parser, data) == outcome(type(parser)(), data)
            if parser.in_message:  # it waits for more, or is dead
                break


def test_heads_that_differ_before_the_length_are_read_apart() -> None:
    paths = ["/a", "/b", "/a", "/RPC2"]
    assert [request.path for request in requests([build_request("h", path, b"12") for path in paths])] == paths
    parser = ResponseParser()
    for status in (200, 404, 200):
        parser.feed(f"HTTP/1.1 {status} Text\r\nContent-Length: 2\r\nX: y\r\n\r\nab".encode())
        response = parser.next_message()
        assert response is not None and response.status == status


def outcome(parser: RequestParser | ResponseParser, data: bytes) -> tuple[object, ...]:
    parser.feed(data)
    try:
        message = parser.next_message()
    except HttpError as error:
        return str(error), error.status
    if message is None:
        return (parser.num_buffered,)
    first = (message.method, message.path) if isinstance(message, Request) else (message.status, message.reason)
    return (*first, message.keep_alive, message.body, parser.num_buffered)
