"""timing: values and arithmetic (P26, P27, O24)."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.timing import Duration, Time, TVal

nanoseconds = st.integers(min_value=-(2**31) * 10**9, max_value=2**31 * 10**9 - 1)
instants = st.integers(min_value=0, max_value=2**32 * 10**9 - 1)


def test_p26_normalisation() -> None:
    assert (Duration(-0.5).secs, Duration(-0.5).nsecs) == (-1, 500000000)
    assert (Time(1, 2_500_000_000).secs, Time(1, 2_500_000_000).nsecs) == (3, 500000000)
    assert Time(1.5) == Time(1, 500000000)


@pytest.mark.parametrize("array", [np.array(1.5), np.array([1.5]), np.array([[1.5]], "float32")], ids=repr)
def test_arrays_of_one_number_are_seconds(array: Any) -> None:
    """As in stock ROS with earlier versions of numpy."""
    for value in (Duration(array), Duration(array, 0), Duration.from_sec(array), Time(array), Time.from_sec(array)):
        assert (value.secs, value.nsecs) == (1, 500_000_000)
    assert Duration(1, array.astype(int)) == Duration(1, 1)
    with pytest.raises(ValueError, match="nsecs cannot be set"):
        Duration(array, 1)
    with pytest.raises(TypeError):
        Duration(np.array([1.5, 2.5]))


def test_p26_errors() -> None:
    with pytest.raises(TypeError):
        Time(-1)
    with pytest.raises(ValueError):
        Duration(1.5, 3)
    with pytest.raises(TypeError):
        Time(1) - Time(2) - Time(3)
    with pytest.raises(TypeError):
        _ = Time(1) < Duration(2)
    with pytest.raises(TypeError):
        _ = Time(1) + Time(2)  # type: ignore[operator]


def test_times_as_received_are_compared_by_their_sum() -> None:
    odd, later = Time(), Time(3)
    odd.secs, odd.nsecs = 1, 4_000_000_000
    assert later < odd and later <= odd and odd > later and odd >= later
    assert odd != Time(5) and odd <= Time(5) <= odd
    odd.canon()
    assert odd == Time(5)


def test_p27_kinds_are_never_equal() -> None:
    assert Time(1) != Duration(1)
    assert Time(1) == Time(1) and hash(Time(1)) == hash(Time(1))
    assert not Time() and Time(0, 1)
    assert str(Time(3, 4)) == "3000000004"


@given(nanoseconds, nanoseconds)
def test_duration_arithmetic_is_integer_arithmetic(a: int, b: int) -> None:
    x, y = Duration.from_nsec(a), Duration.from_nsec(b)
    assert (x + y).to_nsec() == a + b
    assert (x - y).to_nsec() == a - b
    assert (-x).to_nsec() == -a
    assert abs(x).to_nsec() == abs(a)
    assert (x < y) == (a < b) and (x >= y) == (a >= b)
    assert 0 <= x.nsecs < 10**9
    if b:
        assert divmod(x, y) == (a // b, Duration.from_nsec(a % b))


@given(instants, nanoseconds)
def test_time_and_duration(a: int, b: int) -> None:
    t, d = Time.from_nsec(a), Duration.from_nsec(b)
    if a + b >= 0:
        assert (t + d).to_nsec() == (d + t).to_nsec() == a + b
        assert (t + d) - t == d
        assert (t + d) - d == t
    else:
        with pytest.raises(TypeError):
            _ = t + d


def test_duration_scaling() -> None:
    assert Duration(2) * 3 == Duration(6) == 3 * Duration(2)
    assert Duration(2) * 0.5 == Duration(1)
    assert Duration(3) / 2 == Duration(1.5)
    assert Duration(3) / Duration(2) == 1.5
    assert Duration(5) // 2 == Duration(5) // 2.0 == Duration(2)
    with pytest.raises(TypeError):
        Duration(5) % 2  # type: ignore[operator]


def test_o24_a_float_is_cut_to_nanoseconds() -> None:
    assert Time(12345.678901234) == Time(12345, 678901233)
    assert Duration.from_sec(-0.25) == Duration(-1, 750000000)


def test_plain_values_are_of_no_kind() -> None:
    assert TVal(1) == TVal(1) != Time(1)
    assert TVal(1) < Time(2) and Duration(2) > TVal(1)


def test_pickle_keeps_values() -> None:
    assert pickle.loads(pickle.dumps(Time(5, 6))) == Time(5, 6)


@pytest.mark.parametrize("kind", [Time, Duration])
def test_what_is_no_number_is_named(kind: Any) -> None:
    for make, text in (
        (lambda: kind("5"), "secs must be a number, not '5'"),
        (lambda: kind(None), "secs must be a number, not None"),
        (lambda: kind(1, "5"), "nsecs must be a number, not '5'"),
        (lambda: kind.from_sec("5"), "seconds must be a number, not '5'"),
    ):
        with pytest.raises(TypeError, match=text):
            make()
    with pytest.raises(ValueError, match="invalid literal for int"):  # as stock's
        kind("x")
