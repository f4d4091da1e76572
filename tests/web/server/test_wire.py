"""What a page and its server say to each other."""

from __future__ import annotations

import contextlib
import json
import struct
from array import array

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pyros1.web.server import wire
from pyros1.web.server.wire import Call, Change, Close, Next, Open, Push, RequestError

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=10),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=20,
)


@pytest.mark.parametrize(
    ("text", "request_"),
    [
        ('{"call": "a.b", "id": 3, "args": {"x": 1}}', Call(3, "a.b", {"x": 1})),
        ('{"call": "a.b", "id": 3}', Call(3, "a.b", {})),
        ('{"open": "plot", "stream": 0, "args": {}}', Open(0, "plot", {})),
        ('{"change": 7, "args": {"y": []}}', Change(7, {"y": []})),
        ('{"next": 7}', Next(7)),
        ('{"close": 7}', Close(7)),
    ],
)
def test_requests(text: str, request_: wire.Request) -> None:
    assert wire.parse(text) == request_


@pytest.mark.parametrize(
    "text",
    [
        b"{}",
        "",
        "{}",
        "[]",
        "null",
        '{"call": 1, "id": 2}',
        '{"call": "x"}',
        '{"next": -1}',
        '{"next": true}',
        '{"next": 1.5}',
        '{"next": 99999999999}',
        '{"open": "x", "stream": 1, "args": []}',
        "[" * 100_000,
        '{"call": "x", "id": 1, "args": ' + '{"a":' * 5000 + "1" + "}" * 5000 + "}",
        " " * (wire.MAX_REQUEST_LENGTH + 1),
    ],
)
def test_what_is_no_request_is_refused(text: str | bytes) -> None:
    try:
        found = wire.parse(text)
    except RequestError as error:
        assert len(str(error)) < 200
    else:
        assert isinstance(found, Call)  # a newer Python reads deep JSON


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.too_slow])
@given(st.text() | JSON.map(json.dumps))
def test_any_text_is_a_request_or_refused(text: str) -> None:
    with contextlib.suppress(RequestError):
        wire.parse(text)


def test_frames() -> None:
    assert json.loads(wire.result(1, {"x": [1, None]})) == {"id": 1, "result": {"x": [1, None]}}
    assert json.loads(wire.failure(1, "no \udcff")) == {"id": 1, "error": "no \udcff"}
    assert json.loads(wire.push(2, Push("x"))) == {"stream": 2, "data": "x"}
    assert json.loads(wire.problem(2, "bad")) == {"stream": 2, "error": "bad"}


@pytest.mark.slow
@given(JSON.filter(lambda value: "NaN" not in json.dumps(value) and "Inf" not in json.dumps(value)))
def test_a_push_with_numbers_is_aligned(data: object) -> None:
    numbers = array("d", [1.5, -2.0])
    frame = wire.push(9, Push(data, numbers.tobytes()))
    assert isinstance(frame, bytes)
    (length,) = struct.unpack_from("<I", frame)
    assert (4 + length) % 8 == 0  # where JavaScript can look at it as float64
    assert json.loads(frame[4 : 4 + length]) == {"stream": 9, "data": data}
    assert array("d", frame[4 + length :]) == numbers
