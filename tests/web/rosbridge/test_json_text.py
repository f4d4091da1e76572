"""Messages as JSON, beside what `json` makes of their fields."""

from __future__ import annotations

import base64
import json
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.timing import Duration, Time
from pyros1.msgs import Message, from_definition
from pyros1.web.rosbridge import frames, json_text, values

from ...bodies import decode, encode

PART = from_definition("test_msgs/Part", "float32 real\nstring name\nbool[2] flags\nchar letter\nbyte octet\n")
WHOLE = from_definition(
    "test_msgs/Whole",
    f"""bool flag
int64 number
float64 real
string text
time at
duration span
Part part
Part[] parts
uint8[] octets
char[3] letters
int8[] small
uint64[] large
float32[] reals
float64[2] pair
bool[] flags
string[] texts
time[] times
duration[1] spans
{"=" * 80}
MSG: test_msgs/Part
{PART._full_text}""",
)
_REALS = st.floats(width=32) | st.sampled_from([0.0, -0.0, 1e-7, 1e30, math.inf, -math.inf, math.nan])
_TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=8) | st.sampled_from(["nan", "inf", '"\\\n\0', "ä"])
_TIMES = st.builds(Time, st.integers(0, 2**32 - 1), st.integers(0, 10**9 - 1))
_SPANS = st.builds(Duration, st.integers(-(2**31), 2**31 - 1), st.integers(0, 10**9 - 1))
_PARTS = st.builds(
    PART,
    real=_REALS,
    name=_TEXTS,
    flags=st.lists(st.booleans(), min_size=2, max_size=2),
    letter=st.integers(0, 255),
    octet=st.integers(-128, 127),
)
_WHOLES = st.builds(
    WHOLE,
    flag=st.booleans(),
    number=st.integers(-(2**63), 2**63 - 1),
    real=_REALS,
    text=_TEXTS,
    at=_TIMES,
    span=_SPANS,
    part=_PARTS,
    parts=st.lists(_PARTS, max_size=3),
    octets=st.binary(max_size=9),
    letters=st.binary(min_size=3, max_size=3),
    small=st.lists(st.integers(-128, 127), max_size=5),
    large=st.lists(st.integers(0, 2**64 - 1), max_size=5),
    reals=st.lists(_REALS, max_size=5),
    pair=st.lists(_REALS, min_size=2, max_size=2),
    flags=st.lists(st.booleans(), max_size=5),
    texts=st.lists(_TEXTS, max_size=4),
    times=st.lists(_TIMES, max_size=3),
    spans=st.lists(_SPANS, min_size=1, max_size=1),
)


def plain(value: Any) -> Any:
    """Return a field's value as clients should see it."""
    if isinstance(value, Message):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, Time | Duration):
        return {"secs": value.secs, "nsecs": value.nsecs}
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return [*map(plain, value)] if isinstance(value, (list, tuple)) else value


@pytest.mark.slow
@pytest.mark.parametrize("faster", [True, False], ids=["orjson", "plain"])
@given(message=_WHOLES)
def test_any_message(faster: bool, message: Message) -> None:
    with pytest.MonkeyPatch.context() as patch:
        if not faster:
            patch.setattr(json_text, "array_encoder", None)
        check(message)


def check(message: Message) -> None:
    """Write a message, and read it again."""
    body = encode(message)
    expected = json.dumps(plain(decode(WHOLE, body)))
    for each in (decode(WHOLE, body), values.decode(WHOLE, body)):
        assert json.dumps(json.loads(frames.to_json(each))) == expected
