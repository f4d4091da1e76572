"""What dynamic_reconfigure can say of the parameters of a ROS 2 node."""

from __future__ import annotations

import math
from typing import Any

from pyros1.msgs.dynamic_reconfigure.msg import BoolParameter, Config, DoubleParameter, IntParameter, StrParameter
from pyros1.reconfigure.encoding import decode, decode_description, parameters_of
from pyros1.ros2.bridge.parameters.configuration import MAX_STRING, MAX_TEXT, Configuration
from pyros1.ros2.bridge.parameters.messages import Descriptor, Value

BOUNDED = {
    "count": Descriptor("count", "", False, (1, 9), None),
    "gain": Descriptor("gain", "", False, None, (0.0, 1.0)),
}


def configured(said: dict[str, Descriptor] | None = None, **values: Value | None) -> Configuration:
    known = said or {}
    return Configuration(
        [known.get(name, Descriptor(name, "", False)) for name in values],
        {name: value for name, value in values.items() if value is not None},
    )


def values_of(configuration: Configuration) -> dict[str, Any]:
    values: dict[str, Any] = decode(configuration.message(), dict)
    return values


def described(configuration: Configuration) -> dict[str, Any]:
    return {each["name"]: each for each in parameters_of(decode_description(configuration.description(), dict))}


def test_what_has_no_counterpart() -> None:
    said = {"fixed": Descriptor("fixed", "", True)}
    values: dict[str, Any] = {
        "a b": 1,
        "": 1,
        "x\n": 1,
        "n" * 256: 1,
        "groups": 1,
        "fixed": 1,
        "unset": None,
        "many": [1],
        "big": 1 << 31,
        "small": -(1 << 31) - 1,
        "long": "x" * (MAX_STRING + 1),
        "lowest": -(1 << 31),
        "nested.name/x": "y" * MAX_STRING,
    }
    configuration = configured(said, **values)
    assert configuration.names == ["lowest", "nested.name/x"]
    assert configuration.left_out == {
        **dict.fromkeys(["a b", "", "x\n", "n" * 256, "groups"], "its name is not allowed"),
        "fixed": "read-only",
        "unset": "without a value",
        "many": "an array",
        "big": "more than 32 bits",
        "small": "more than 32 bits",
        "long": "too long",
    }


def test_the_size_of_all_texts_is_limited() -> None:
    values = {f"p{number}": "x" * MAX_STRING for number in range(200)}
    configuration = configured(None, **values)
    size = sum(len(name) + len(value) for name, value in values_of(configuration).items())
    assert MAX_TEXT - 2 * MAX_STRING < size <= MAX_TEXT
    assert {*configuration.left_out.values()} == {"the node has too much text"}
    configuration = configured(None, **dict.fromkeys(values, ""))
    assert configuration.update({f"p{number}": values[f"p{number}"] for number in range(50)})
    assert not configuration.update(values)
    assert sum(map(len, values_of(configuration).values())) <= MAX_TEXT
    assert configuration.update({f"p{number}": "" for number in range(200)})
    assert configuration.update({"p199": "x" * MAX_STRING}), "there is room again"


def test_limits() -> None:
    limits = described(configured(BOUNDED, count=5, gain=0.5, free=1.0, flag=True, text="x"))
    assert {name: (each["min"], each["max"]) for name, each in limits.items()} == {
        "count": (1, 9),
        "gain": (0.0, 1.0),
        "free": (-math.inf, math.inf),
        "flag": (False, True),
        "text": ("", ""),
    }
    odd = {
        "count": Descriptor("count", "", False, (-(1 << 63), (1 << 63) - 1), None),
        "back": Descriptor("back", "", False, (9, 1), None),
        "nan": Descriptor("nan", "", False, None, (math.nan, 1.0)),
        "other": Descriptor("other", "", False, None, (0.0, 1.0)),
    }
    limits = described(configured(odd, count=5, back=5, nan=0.5, other=5))
    whole = (-(1 << 31), (1 << 31) - 1)
    assert {name: (each["min"], each["max"]) for name, each in limits.items()} == {
        "count": whole,
        "back": whole,
        "nan": (-math.inf, math.inf),
        "other": whole,
    }


def test_long_descriptions_are_cut() -> None:
    (each,) = described(configured({"a": Descriptor("a", "x" * 5000, False)}, a=1)).values()
    assert each["description"] == "x" * 1000


def test_updates() -> None:
    configuration = configured(None, count=5, text="x")
    assert configuration.update({"count": 6, "unknown": 1, "array": [1]})
    assert values_of(configuration) == {"count": 6, "text": "x"}
    news: list[dict[str, Any]] = [{"count": 1.0}, {"count": True}, {"count": None}, {"count": 1 << 31}, {"text": ["x"]}]
    for each in news:
        assert not configuration.update(each), each
    assert values_of(configuration) == {"count": 6, "text": "x"}


def test_requests() -> None:
    configuration = configured(BOUNDED, count=5, gain=0.5, flag=False, text="x")
    request = Config(
        bools=[BoolParameter("flag", True), BoolParameter("count", True)],
        ints=[IntParameter("count", 99), IntParameter("gain", 1)],
        strs=[StrParameter("text", "y"), StrParameter("missing", "z")],
        doubles=[DoubleParameter("count", 1.0)],
    )
    values, problems = configuration.requested(request)
    assert values == {"flag": True, "count": 9, "gain": 1.0, "text": "y"} and type(values["gain"]) is float
    assert problems == [
        "parameter count is of type int, not bool",
        "there is no parameter missing that can be changed",
        "parameter count is of type int, not double",
    ]
