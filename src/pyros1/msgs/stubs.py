"""Stubs of generated modules, for editors and type checkers: ``pyros1.msgs.<package>.msg`` and ``.srv`` as .pyi text.

Everything that a stub imports has a name that begins with an underscore: no field, constant or type can have it, so
that none can hide it. Pure.
"""

from __future__ import annotations

import keyword
from collections.abc import Iterable, Sequence

from pyros1.msgs.factory import python_name
from pyros1.msgs.spec import STRUCT_CODES, Field, MessageSpec, ServiceSpec

_HEAD = """# Made by pyros1 from the definitions of {package}; changes would be lost.
import builtins as _b
from collections.abc import Sequence as _Sequence
from typing import ClassVar as _ClassVar
from typing import SupportsFloat as _SupportsFloat
from typing import SupportsIndex as _SupportsIndex

from pyros1.msgs import {base} as _Base
from pyros1.msgs.base import Array as _Array
from pyros1.timing import Duration as _Duration
from pyros1.timing import Time as _Time
"""


def package_stub(package: str) -> str:
    """Return the stub of a package's ``__init__``."""
    return f'"""Definitions of the ROS package {package}."""\n'


def message_stub(package: str, specs: Sequence[MessageSpec], module_name: str) -> str:
    """Return the stub of a package's ``msg`` module.

    Args:
        package: the ROS package.
        specs: its messages.
        module_name: of the package below ``pyros1.msgs``.
    """
    body = "".join(_message(spec, spec.name.partition("/")[2]) for spec in specs if _is_usable(spec.name))
    return _module(package, "Message", specs, module_name, body)


def service_stub(package: str, specs: Sequence[ServiceSpec], module_name: str) -> str:
    """Return the stub of a package's ``srv`` module; arguments as for `message_stub`."""
    body = ""
    for spec in specs:
        if _is_usable(spec.name):
            short = spec.name.partition("/")[2]
            body += _message(spec.request, short + "Request", "_Message") + _message(
                spec.response, short + "Response", "_Message"
            )
            body += (
                f"\nclass {short}(_Base):\n"
                f"    _request_class: _ClassVar[_b.type[{short}Request]]\n"
                f"    _response_class: _ClassVar[_b.type[{short}Response]]\n"
            )
    both = [message for spec in specs for message in (spec.request, spec.response)]
    return _module(package, "Service", both, module_name, body, "from pyros1.msgs import Message as _Message\n")


def _module(package: str, base: str, specs: Iterable[MessageSpec], module_name: str, body: str, more: str = "") -> str:
    used = {field.base.partition("/")[0] for spec in specs for field in spec.fields if not field.is_builtin}
    imports = "".join(
        f"from pyros1.msgs.{module_name if name == package else name} import msg as _{name}\n" for name in sorted(used)
    )
    return _HEAD.format(package=package, base=base) + more + imports + body


def _message(spec: MessageSpec, short: str, base: str = "_Base") -> str:
    fields = [(python_name(field.name), *_types(field)) for field in spec.fields]
    lines = [f"\nclass {short}({base}):"]
    for constant in spec.constants:
        lines.append(f"    {python_name(constant.name)}: _ClassVar[_b.{type(constant.value).__name__}]")
    for field, (name, given, taken) in zip(spec.fields, fields, strict=True):
        if field.length is None:
            lines.append(f"    {name}: {given}")
        else:
            lines.append(f"    @_b.property\n    def {name}(self) -> {given}: ...")
            lines.append(f"    @{name}.setter\n    def {name}(self, value: {taken}, /) -> None: ...")
    arguments = "".join(f", {name}: {taken} = ..." for name, _, taken in fields)
    lines.append(f"    def __init__(self{arguments}) -> None: ...")
    return "\n".join(lines) + "\n"


def _types(field: Field) -> tuple[str, str]:
    """Return the type that a field has, and that of what it takes."""
    package, _, short = field.base.partition("/")
    one, taken = {
        "time": ("_Time", "_Time"),
        "duration": ("_Duration", "_Duration"),
        "string": ("_b.str", "_b.str"),
        "bool": ("_b.bool", "_b.bool | _SupportsIndex"),
        "float32": ("_b.float", "_SupportsFloat"),
        "float64": ("_b.float", "_SupportsFloat"),
    }.get(field.base, (f"_{package}.{short}",) * 2 if short else ("_b.int", "_SupportsIndex"))
    if field.length is None:
        return one, taken
    if field.base in ("uint8", "char"):
        return "_b.bytes", "_Array"
    # Received arrays of numbers are tuples, others are lists.
    return (f"_Sequence[{one}]", "_Array") if field.base in STRUCT_CODES else (f"_b.list[{one}]", f"_Sequence[{one}]")


def _is_usable(name: str) -> bool:
    """Return whether a class statement can have the name of a type."""
    return not keyword.iskeyword(name.partition("/")[2])
