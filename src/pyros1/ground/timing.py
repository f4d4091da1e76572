"""Time and Duration, with nanosecond resolution, and their arithmetic (https://wiki.ros.org/roscpp/Overview/Time).

Both consist of whole seconds and nanoseconds, normalised to ``0 <= nsecs < 1e9`` unless the attributes are set
directly, as in nested parts of received messages. A Time is a point in time and never negative; a Duration can be
negative. This module does not read any clock.
"""

from __future__ import annotations

from typing import Any, ClassVar, TypeVar

_NS_PER_S = 1_000_000_000
_T = TypeVar("_T", bound="TVal")


def _as_int(number: Any, name: str) -> int:
    if isinstance(number, (str, bytes)):
        int(number)  # raises ValueError if it is not a number, as in stock ROS
    if isinstance(number, (str, bytes)) or not hasattr(type(number), "__int__"):
        raise TypeError(f"{name} must be a number, not {number!r:.80}")
    return int(scalar(number))


def _has_fractions(number: Any) -> bool:
    """Return whether a value's type can represent fractions, such as numpy.float32 or Decimal."""
    number_type = type(number)
    # numpy arrays have __index__, whatever their elements; __len__ identifies them.
    return hasattr(number_type, "__float__") and (
        not hasattr(number_type, "__index__") or hasattr(number_type, "__len__")
    )


def scalar(number: Any) -> Any:
    """Return the element of a one-element numpy array, which newer versions of numpy do not convert; return any other
    value unchanged.
    """
    return number.item() if getattr(number, "ndim", 0) and number.size == 1 else number


class TVal:
    """Base of Time and Duration: seconds and nanoseconds.

    Args:
        secs: seconds; a float or another fractional number is allowed if ``nsecs`` is 0.
        nsecs: nanoseconds, any integer; whole seconds are carried over into ``secs``.

    Raises:
        ValueError: ``secs`` is a float and ``nsecs`` is not 0, or one of the two is a string that is not a number.
        TypeError: ``secs`` or ``nsecs`` is not a number.
    """

    __slots__ = ("secs", "nsecs")  # noqa: RUF023  in the order in which programs display them
    _slot_types: ClassVar[list[str]] = ["int32", "int32"]  # needed by programs that traverse messages by their slots

    secs: int
    nsecs: int

    def __init__(self, secs: float = 0, nsecs: int = 0) -> None:
        if secs.__class__ is not int:
            if isinstance(secs, float) or _has_fractions(secs):
                secs = float(scalar(secs))
                if nsecs:
                    raise ValueError("if secs is a float, nsecs cannot be set")
                seconds = int(secs)
                secs, nsecs = seconds, int((secs - seconds) * 1e9)  # truncated, not rounded, as in stock ROS
            else:
                secs = _as_int(secs, "secs")
        if nsecs.__class__ is not int:
            nsecs = _as_int(nsecs, "nsecs")
        if not 0 <= nsecs < _NS_PER_S:
            carry, nsecs = divmod(int(nsecs), _NS_PER_S)
            secs += carry
        self.secs = secs
        self.nsecs = nsecs

    @classmethod
    def from_sec(cls: type[_T], float_secs: float) -> _T:
        """Return the Time or Duration for a number of seconds, which can have fractions.

        Raises:
            TypeError: ``float_secs`` is not a number.
        """
        if not hasattr(type(float_secs), "__float__"):
            raise TypeError(f"seconds must be a number, not {float_secs!r:.80}")
        return cls(float(scalar(float_secs)))

    from_seconds = from_sec

    @classmethod
    def from_nsec(cls: type[_T], nanoseconds: int) -> _T:
        """Return the Time or Duration for a whole number of nanoseconds."""
        return cls(*divmod(nanoseconds, _NS_PER_S))

    @classmethod
    def of_clock(cls: type[_T], nanoseconds: int) -> _T:
        """Return the Time or Duration for a clock reading in nanoseconds, which must not be negative. Faster than
        `from_nsec`.
        """
        value = cls.__new__(cls)
        value.secs, value.nsecs = divmod(nanoseconds, _NS_PER_S)
        return value

    def to_sec(self) -> float:
        """Return the value in seconds as a float. For present-day times, a float is exact to microseconds, not to
        nanoseconds.
        """
        return self.secs + self.nsecs / 1e9

    def to_nsec(self) -> int:
        """Return the value as whole nanoseconds."""
        return self.secs * _NS_PER_S + self.nsecs

    def is_zero(self) -> bool:
        """Return whether the value is exactly 0."""
        return not self.secs and not self.nsecs

    def set(self, secs: int, nsecs: int) -> None:
        """Set seconds and nanoseconds, and normalise them."""
        TVal.__init__(self, secs, nsecs)

    def canon(self) -> None:
        """Normalise the attributes after they have been set directly."""
        TVal.__init__(self, self.secs, self.nsecs)

    def __bool__(self) -> bool:
        return bool(self.secs or self.nsecs)

    def __eq__(self, other: object) -> bool:
        if other.__class__ is not self.__class__ and (
            not isinstance(other, TVal) or _base_class(self) is not _base_class(other)
        ):
            return False
        return self.secs == other.secs and self.nsecs == other.nsecs

    def __lt__(self, other: object) -> bool:
        if other.__class__ is self.__class__:
            return self.secs * _NS_PER_S + self.nsecs < other.secs * _NS_PER_S + other.nsecs
        difference = _difference(self, other)
        return NotImplemented if difference is None else difference < 0

    def __le__(self, other: object) -> bool:
        if other.__class__ is self.__class__:
            return self.secs * _NS_PER_S + self.nsecs <= other.secs * _NS_PER_S + other.nsecs
        difference = _difference(self, other)
        return NotImplemented if difference is None else difference <= 0

    def __gt__(self, other: object) -> bool:
        if other.__class__ is self.__class__:
            return self.secs * _NS_PER_S + self.nsecs > other.secs * _NS_PER_S + other.nsecs
        difference = _difference(self, other)
        return NotImplemented if difference is None else difference > 0

    def __ge__(self, other: object) -> bool:
        if other.__class__ is self.__class__:
            return self.secs * _NS_PER_S + self.nsecs >= other.secs * _NS_PER_S + other.nsecs
        difference = _difference(self, other)
        return NotImplemented if difference is None else difference >= 0

    def __hash__(self) -> int:
        return hash((self.secs, self.nsecs))

    def __str__(self) -> str:
        return str(self.to_nsec())

    def __repr__(self) -> str:
        module = type(self).__module__.partition(".")[0]  # stock's classes include it: genpy.Time, rospy.Time
        name = type(self).__name__
        return f"{name if module == 'pyros1' else f'{module}.{name}'}[{self.to_nsec()}]"

    def __getstate__(self) -> list[int]:
        return [self.secs, self.nsecs]

    def __setstate__(self, state: list[int]) -> None:
        self.secs, self.nsecs = state


def _base_class(value: object) -> type[TVal] | None:
    """Return the base class of ``value``, Time or Duration: subclasses can be compared and combined with their base
    classes.
    """
    return Time if isinstance(value, Time) else Duration if isinstance(value, Duration) else None


def _difference(a: TVal, b: object) -> int | None:
    """Return the difference of two values in nanoseconds, or None if one is a Time and the other a Duration, or ``b``
    is neither.
    """
    if not isinstance(b, TVal):
        return None
    if _base_class(a) is not _base_class(b) and None not in (_base_class(a), _base_class(b)):
        return None
    return a.to_nsec() - b.to_nsec()


class Time(TVal):
    """A point in time: seconds and nanoseconds since the epoch, or since the start of a simulation.

    Raises:
        TypeError: the time would be negative.
    """

    __slots__ = ()

    def __init__(self, secs: float = 0, nsecs: int = 0) -> None:
        super().__init__(secs, nsecs)
        if self.secs < 0:
            raise TypeError("time values must be positive")

    def to_time(self) -> float:
        """Return the time in seconds, like :meth:`to_sec`."""
        return self.to_sec()

    def __add__(self, other: object) -> Time:
        if not isinstance(other, Duration):
            return NotImplemented
        return Time(self.secs + other.secs, self.nsecs + other.nsecs)

    __radd__ = __add__

    def __sub__(self, other: object) -> Any:
        if isinstance(other, Time):
            return Duration(self.secs - other.secs, self.nsecs - other.nsecs)
        if isinstance(other, Duration):
            return Time(self.secs - other.secs, self.nsecs - other.nsecs)
        return NotImplemented


class Duration(TVal):
    """A span of time, possibly negative: -0.5 s is ``secs=-1, nsecs=500000000``."""

    __slots__ = ()

    def __add__(self, other: object) -> Any:
        if isinstance(other, Duration):
            return Duration(self.secs + other.secs, self.nsecs + other.nsecs)
        return NotImplemented  # Time + Duration is handled by Time

    def __sub__(self, other: object) -> Duration:
        if not isinstance(other, Duration):
            return NotImplemented
        return Duration(self.secs - other.secs, self.nsecs - other.nsecs)

    def __neg__(self) -> Duration:
        return Duration(-self.secs, -self.nsecs)

    def __abs__(self) -> Duration:
        return -self if self.secs < 0 else self

    def __mul__(self, factor: object) -> Duration:
        if isinstance(factor, int):
            return Duration(self.secs * factor, self.nsecs * factor)
        if isinstance(factor, float):
            return Duration.from_sec(self.to_sec() * factor)
        return NotImplemented

    __rmul__ = __mul__

    def __floordiv__(self, other: object) -> Any:
        if isinstance(other, Duration):
            return self.to_nsec() // other.to_nsec()
        if isinstance(other, (int, float)):  # the result is whole seconds
            return Duration.from_sec(self.to_sec() // other)
        return NotImplemented

    def __truediv__(self, other: object) -> Any:
        if isinstance(other, Duration):
            return self.to_sec() / other.to_sec()
        if isinstance(other, (int, float)):
            return Duration.from_sec(self.to_sec() / other)
        return NotImplemented

    def __mod__(self, other: object) -> Any:
        if isinstance(other, Duration):
            return Duration.from_nsec(self.to_nsec() % other.to_nsec())
        return NotImplemented

    def __divmod__(self, other: object) -> Any:
        if isinstance(other, Duration):
            return self // other, self % other
        return NotImplemented


# The slots already exist; programs that traverse messages expect their names here.
Time.__slots__ = Duration.__slots__ = TVal.__slots__  # type: ignore[assignment]
