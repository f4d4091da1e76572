"""What a plain word of YAML means, by the rules said in `pyros1.values.reading`: its tag, and its value."""

from __future__ import annotations

import base64
import datetime
import math
import re
from collections.abc import Callable
from typing import Any

BOOLEANS = {"yes": True, "no": False, "true": True, "false": False, "on": True, "off": False}
_BOOL = re.compile(r"yes|Yes|YES|no|No|NO|true|True|TRUE|false|False|FALSE|on|On|ON|off|Off|OFF")
_NULL = re.compile(r"~|null|Null|NULL|")
_INT = re.compile(r"[-+]?(?:0b[0-1_]+|0[0-7_]+|(?:0|[1-9][0-9_]*)|0x[0-9a-fA-F_]+|[1-9][0-9_]*(?::[0-5]?[0-9])+)")
_FLOAT = re.compile(
    r"[-+]?[0-9][0-9_]*\.[0-9_]*(?:[eE][-+][0-9]+)?|\.[0-9][0-9_]*(?:[eE][-+][0-9]+)?"
    r"|[-+]?[0-9][0-9_]*(?::[0-5]?[0-9])+\.[0-9_]*|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)"
)
_TIMESTAMP = re.compile(
    r"(?P<year>\d{4})-(?P<month>\d\d?)-(?P<day>\d\d?)"
    r"(?:(?:[Tt]|[ \t]+)(?P<hour>\d\d?):(?P<minute>\d\d):(?P<second>\d\d)(?:\.(?P<fraction>\d*))?"
    r"(?:[ \t]*(?P<zone>Z|(?P<sign>[-+])(?P<zone_hour>\d\d?)(?::(?P<zone_minute>\d\d))?))?)?"
)
_STRICT_DATE = re.compile(r"\d{4}-\d\d-\d\d")
_DEGREES = re.compile(r"deg\([^)]*\)")
_RADIANS = re.compile(r"rad\([^)]*\)")


def scalar_tag(value: str) -> str:  # noqa: PLR0911 - one rule, one line
    """Return the YAML 1.1 tag (without prefix) of a plain, untagged scalar, or ``degrees``/``radians``."""
    if _BOOL.fullmatch(value):
        return "bool"
    if _FLOAT.fullmatch(value):
        return "float"
    if _INT.fullmatch(value):
        return "int"
    if _NULL.fullmatch(value):
        return "null"
    if value == "<<":
        return "merge"
    if value == "=":
        return "value"
    match = _TIMESTAMP.fullmatch(value)
    if match and (match["hour"] or _STRICT_DATE.fullmatch(value)):
        return "timestamp"
    if _DEGREES.fullmatch(value):
        return "degrees"
    if _RADIANS.fullmatch(value):
        return "radians"
    return "str"


_LONGEST_INTEGER = 200
"""Characters of an integer: no field holds 2^64, and Python does not write those of thousands of digits."""


def _integer(text: str) -> int:
    if len(text) > _LONGEST_INTEGER:
        raise ValueError(f"an integer of {len(text)} digits")
    digits = text.replace("_", "")
    sign = -1 if digits.startswith("-") else 1
    digits = digits.lstrip("+-") if digits[:1] in "+-" else digits
    if digits == "0":
        return 0
    if digits.startswith("0b"):
        return sign * int(digits[2:], 2)
    if digits.startswith("0x"):
        return sign * int(digits[2:], 16)
    if digits.startswith("0"):
        return sign * int(digits, 8)
    if ":" in digits:
        return sign * int(_sexagesimal([int(part) for part in digits.split(":")]))
    return sign * int(digits)


def _float(text: str) -> float:
    digits = text.replace("_", "").lower()
    sign = -1.0 if digits.startswith("-") else 1.0
    digits = digits[1:] if digits[:1] in ("+", "-") else digits
    if digits == ".inf":
        return sign * math.inf
    if digits == ".nan":
        return math.nan
    if ":" in digits:
        return sign * float(_sexagesimal([float(part) for part in digits.split(":")]))
    return sign * float(digits)


def _sexagesimal(parts: list[Any]) -> Any:
    total: Any = 0
    for part in parts:
        total = total * 60 + part
    return total


def _binary(text: str) -> bytes:
    return base64.b64decode(text.encode("ascii"))


def _timestamp(text: str) -> datetime.date | datetime.datetime:
    match = _TIMESTAMP.fullmatch(text)
    if match is None:
        raise ValueError(text)
    day = datetime.date(int(match["year"]), int(match["month"]), int(match["day"]))
    if not match["hour"]:
        return day
    fraction = int(((match["fraction"] or "")[:6]).ljust(6, "0"))
    zone = None
    if match["zone"]:
        offset = datetime.timedelta(hours=int(match["zone_hour"] or 0), minutes=int(match["zone_minute"] or 0))
        zone = datetime.timezone(-offset if match["sign"] == "-" else offset)
    clock = datetime.time(int(match["hour"]), int(match["minute"]), int(match["second"]), fraction, zone)
    return datetime.datetime.combine(day, clock)


def _degrees(text: str) -> float:
    inner = text[4:-1] if _DEGREES.fullmatch(text) else text
    return float(inner) * math.pi / 180.0  # not math.radians, which differs from stock in the last digit


def _radians(text: str) -> float:
    from pyros1.values.angles import radians  # noqa: PLC0415 - rarely needed, and it loads Python's parser

    return radians(text[4:-1] if _RADIANS.fullmatch(text) else text)


SCALARS: dict[str, Callable[[str], Any]] = {
    "null": lambda text: None,
    "bool": lambda text: BOOLEANS[text.lower()],
    "int": _integer,
    "float": _float,
    "str": str,
    "binary": _binary,
    "timestamp": _timestamp,
    "!degrees": _degrees,
    "!radians": _radians,
}
