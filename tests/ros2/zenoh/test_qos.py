"""QoS profiles in tokens."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import SerializationError
from pyros1.ros2.zenoh.qos import UNWRITTEN_DEPTH, Qos, decode_qos, encode_qos

WRITTEN = {
    "1:2:1,10:,:,:,,": Qos(),
    "1:1:1,1:,:,:,,": Qos(transient_local=True, depth=1),
    "2:2:1,5:,:,:,,": Qos(reliable=False, depth=5),
    "1:2:2,10:,:,:,,": Qos(keep_all=True),
}
READ = {
    # These two are from zenoh-ros2-sdk 0.1.8.
    "::,10:,:,:,,": Qos(),
    ":1:,1:,:,:,,": Qos(transient_local=True, depth=1),
    "::,:,:,:,,": Qos(depth=UNWRITTEN_DEPTH),
    "::,0:,:,:,,": Qos(depth=UNWRITTEN_DEPTH),
    "2::,:,:,:,,": Qos(reliable=False, depth=UNWRITTEN_DEPTH),
    "::2,:,:,:,,": Qos(depth=UNWRITTEN_DEPTH, keep_all=True),
    "0:0:0,7:1,2:3,4:1,9223372036,854775807": Qos(depth=7),
    "4:5:3,7:,:,:,,": Qos(depth=7),
    "2:1:1,3,9:,,:,,:,,,:new:9": Qos(reliable=False, transient_local=True, depth=3),
    "::,18446744073709551615:,:,:,,": Qos(depth=(1 << 64) - 1),
}


@pytest.mark.parametrize("text", WRITTEN)
def test_all_fields_are_written(text: str) -> None:
    assert encode_qos(WRITTEN[text]) == text
    assert decode_qos(text) == WRITTEN[text]


@pytest.mark.parametrize("text", READ)
def test_reading(text: str) -> None:
    assert decode_qos(text) == READ[text]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "1:2:1,10:,:,",
        "1:2:1,10:,:,:,",
        "1:2:1,10::,:,,",
        "1:2:1:,:,:,,",
        "x:2:1,10:,:,:,,",
        "1:x:1,10:,:,:,,",
        "1:2:x,10:,:,:,,",
        "1:2:1,x:,:,:,,",
        "1:2:1,-1:,:,:,,",
        "1:2:1,1_0:,:,:,,",
        "1:2:1,18446744073709551616:,:,:,,",
    ],
)
def test_what_is_not_a_profile(text: str) -> None:
    assert decode_qos(text) is None


def test_the_depth_that_is_not_written() -> None:
    assert UNWRITTEN_DEPTH == 42
    assert encode_qos(Qos(depth=0)) == "1:2:1,0:,:,:,,"
    assert encode_qos(Qos(depth=(1 << 64) - 1)) == "1:2:1,18446744073709551615:,:,:,,"


@pytest.mark.parametrize("depth", [-1, 1 << 64])
def test_depths_that_cannot_be_written(depth: int) -> None:
    with pytest.raises(SerializationError):
        encode_qos(Qos(depth=depth))


@given(st.builds(Qos, st.booleans(), st.booleans(), st.integers(1, (1 << 64) - 1), st.booleans()))
def test_there_and_back(qos: Qos) -> None:
    assert decode_qos(encode_qos(qos)) == qos


@given(st.text(max_size=1000) | st.text("0129:,", max_size=40))
def test_any_text(text: str) -> None:
    qos = decode_qos(text)
    assert qos is None or decode_qos(encode_qos(qos)) == qos
