"""The text of stubs; that type checkers take it is tested in tests/finding."""

from __future__ import annotations

import ast

from pyros1.msgs.spec import parse_message, parse_service
from pyros1.msgs.stubs import message_stub, package_stub, service_stub, used_packages


def classes(stub: str) -> dict[str, str]:
    """Return the classes of a stub, as text without blank lines."""
    return {node.name: ast.unparse(node) for node in ast.parse(stub).body if isinstance(node, ast.ClassDef)}


def imports(stub: str) -> list[str]:
    """Return the lines that import types of messages."""
    return [line for line in stub.splitlines() if line.endswith(" as _std_msgs") or line.endswith(" as _p")]


def test_a_field_of_each_kind() -> None:
    text = (
        "int8 LIMIT=3\nstring NAME=x\nfloat32 from\nbool b\nint8 i\nstring s\ntime t\nduration d\nstd_msgs/Header h\n"
        "uint8[] bytes\nchar[3] chars\nint8[] ints\nfloat64[2] floats\nbool[] flags\nstring[] strings\n"
        "time[] times\nOther[] others"
    )
    stub = message_stub("p", [parse_message("p/T", text)])
    arrays = {
        "bytes": ("_b.bytes", "_Array"),
        "chars": ("_b.bytes", "_Array"),
        "ints": ("_Sequence[_b.int]", "_Array"),
        "floats": ("_Sequence[_b.float]", "_Array"),
        "flags": ("_Sequence[_b.bool]", "_Array"),
        "strings": ("_b.list[_b.str]", "_Sequence[_b.str]"),
        "times": ("_b.list[_Time]", "_Sequence[_Time]"),
        "others": ("_b.list[_p.Other]", "_Sequence[_p.Other]"),
    }
    singles = {
        "from_": ("_b.float", "_SupportsFloat"),
        "b": ("_b.bool", "_b.bool | _SupportsIndex"),
        "i": ("_b.int", "_SupportsIndex"),
        "s": ("_b.str", "_b.str"),
        "t": ("_Time", "_Time"),
        "d": ("_Duration", "_Duration"),
        "h": ("_std_msgs.Header", "_std_msgs.Header"),
    }
    expected = "class T(_Base):\n    LIMIT: _ClassVar[_b.int]\n    NAME: _ClassVar[_b.str]\n"
    for name, (one, _) in singles.items():
        expected += f"    {name}: {one}\n"
    for name, (one, taken) in arrays.items():
        expected += f"    @_b.property\n    def {name}(self) -> {one}: ...\n"
        expected += f"    @{name}.setter\n    def {name}(self, value: {taken}, /) -> None: ...\n"
    arguments = "".join(f", {name}: {taken} = ..." for name, (_, taken) in {**singles, **arrays}.items())
    expected += f"    def __init__(self{arguments}) -> None: ...\n"
    assert classes(stub) == {"T": ast.unparse(ast.parse(expected))}
    assert "from pyros1.msgs import Message as _Base\n" in stub and "definitions of p;" in stub


def test_where_types_come_from() -> None:
    specs = [parse_message("p/A", "std_msgs/Header h"), parse_message("p/B", "A a\nint8 i")]
    assert used_packages(specs[0]) == {"std_msgs"} and used_packages(specs[1]) == {"p"}
    assert imports(message_stub("p", specs)) == [
        "from pyros1.msgs.p import msg as _p",
        "from pyros1.msgs.std_msgs import msg as _std_msgs",
    ]
    assert imports(message_stub("p", specs, uses_stock_names=True)) == [
        "from p import msg as _p",
        "from std_msgs import msg as _std_msgs",
    ]
    assert package_stub("p") == '"""Definitions of the ROS package p."""\n'


def test_services() -> None:
    stub = service_stub("p", [parse_service("p/Move", "std_msgs/Header h\n---\nint8 LEFT=1\nA a")])
    assert "from pyros1.msgs import Service as _Base\n" in stub and "import Message as _Message\n" in stub
    assert len(imports(stub)) == 2
    assert classes(stub) == {
        "MoveRequest": "class MoveRequest(_Message):\n    h: _std_msgs.Header\n\n"
        "    def __init__(self, h: _std_msgs.Header=...) -> None:\n        ...",
        "MoveResponse": "class MoveResponse(_Message):\n    LEFT: _ClassVar[_b.int]\n    a: _p.A\n\n"
        "    def __init__(self, a: _p.A=...) -> None:\n        ...",
        "Move": "class Move(_Base):\n    _request_class: _ClassVar[_b.type[MoveRequest]]\n"
        "    _response_class: _ClassVar[_b.type[MoveResponse]]",
    }


def test_names_that_python_reserves_are_left_out() -> None:
    specs = [parse_message(f"p/{name}", "int8 x") for name in ("None", "Fine", "class")]
    assert [*classes(message_stub("p", specs))] == ["Fine"]
    services = [parse_service(f"p/{name}", "int8 x\n---\n") for name in ("True", "Fine")]
    assert [*classes(service_stub("p", services))] == ["FineRequest", "FineResponse", "Fine"]
