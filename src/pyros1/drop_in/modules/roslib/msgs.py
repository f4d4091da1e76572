"""Definitions of messages, from before genmsg."""

from __future__ import annotations

import os
import re
from typing import Any

from genmsg.base import COMMENTCHAR, CONSTCHAR, SEP, InvalidMsgSpec
from genmsg.msg_loader import MsgContext, load_msg_from_string
from genmsg.msgs import (
    BUILTIN_TYPES,
    DURATION,
    DURATION_MSG,
    HEADER,
    PRIMITIVE_TYPES,
    TIME,
    TIME_MSG,
    Constant,
    Field,
    is_builtin,
    is_header_type,
    is_valid_constant_type,
    is_valid_msg_field_name,
    is_valid_msg_type,
    resolve_type,
)
from genmsg.msgs import MsgSpec as _MsgSpec
from genmsg.msgs import bare_msg_type as base_msg_type
from genmsg.msgs import parse_type as _parse_type

from pyros1.drop_in.missing import missing
from pyros1.ground.errors import MessageError
from pyros1.ground.generated import finder

_NO_PACKAGE = "none"
EXT = ".msg"
VERBOSE = False
RESERVED_TYPES = [*BUILTIN_TYPES, HEADER]
EXTENDED_BUILTINS: dict[str, _MsgSpec] = {
    name: MsgContext.create_default().get_registered(name) for name in (TIME, DURATION)
}
MsgSpecException = InvalidMsgSpec

REGISTERED_TYPES: dict[str, _MsgSpec] = {}
"""The definitions that programs have registered; all others are found when they are used."""
_loaded: set[str] = set()

__getattr__ = missing(__name__)


class MsgSpec(_MsgSpec):
    """A message's definition, which needs no full name; arguments as for `genmsg.msgs.MsgSpec`.

    Attributes:
        header_present: whether the first field is the header that publishers fill in.
    """

    def __init__(
        self,
        types: list[str],
        names: list[str],
        constants: list[Constant],
        text: str,
        full_name: str = "",
        short_name: str = "",
        package: str = "",
    ) -> None:
        super().__init__(types, names, constants, text, full_name)
        self.short_name, self.package = short_name, package
        self.header_present = self.has_header()


def is_verbose() -> bool:
    """Return what `set_verbose` told."""
    return VERBOSE


def set_verbose(v: bool) -> None:
    """Tell whether progress is shown; there is none to show."""
    global VERBOSE  # noqa: PLW0603
    VERBOSE = v


def parse_type(type_: str) -> tuple[str, bool, int | None]:
    """Return a type without brackets, whether it is an array, and its length; raises MsgSpecException."""
    try:
        return _parse_type(type_)
    except ValueError as error:
        raise MsgSpecException(str(error)) from None


def load_from_string(text: str, package_context: str = "", full_name: str = "", short_name: str = "") -> MsgSpec:
    """Return the definition in a text; raises MsgSpecException."""
    package = package_context or _NO_PACKAGE
    spec = load_msg_from_string(MsgContext(), text, f"{package}/{short_name or 'Type'}")
    types = [kind.removeprefix(f"{_NO_PACKAGE}/") for kind in spec.types]
    if re.search(r"^\s*Header\b", text, re.MULTILINE):  # as it is written
        types = [kind.replace("std_msgs/Header", HEADER) for kind in types]
    return MsgSpec(types, spec.names, spec.constants, text, full_name, short_name, package_context)


def load_from_file(file_path: str, package_context: str = "") -> tuple[str, MsgSpec]:
    """Return name and definition of a message in a file; the name is without a package if none is given."""
    short = os.path.basename(file_path).removesuffix(EXT)
    name = f"{package_context}/{short}" if package_context else short
    with open(file_path, encoding="utf-8") as file:
        return name, load_from_string(file.read(), package_context, name, short)


def load_by_type(msgtype: str, package_context: str = "") -> tuple[str, MsgSpec]:
    """Return name and definition of a message; raises MsgSpecException if there is none, or it is wrong."""
    name = msgtype if SEP in msgtype else f"{package_context}/{msgtype}"
    try:
        text = finder().library.message(name).text
    except MessageError as error:
        raise MsgSpecException(str(error)) from error
    package, _, short = name.partition(SEP)
    return name, load_from_string(text, package, name, short)


def register(msg_type_name: str, msg_spec: _MsgSpec) -> None:
    """Let a name stand for a definition."""
    REGISTERED_TYPES[msg_type_name] = msg_spec


def _begin() -> None:
    """Register what is always there."""
    if REGISTERED_TYPES.keys() >= EXTENDED_BUILTINS.keys():
        return
    header = load_by_type("std_msgs/Header")[1]
    for name in (HEADER, "std_msgs/Header", "roslib/Header"):
        register(name, header)
    for name, spec in EXTENDED_BUILTINS.items():
        register(name, spec)


def reinit() -> None:
    """Forget all that was registered, but the types that are always there."""
    _loaded.clear()
    REGISTERED_TYPES.clear()
    _begin()


def load_package(package: str) -> None:
    """Register the messages of a package, under their full names, and once more with the package in front.

    Raises:
        InvalidROSPkgException: there is no such package.
    """
    _begin()
    if package in _loaded:
        return
    specs = _specs_of(package)
    _loaded.add(package)
    for name, spec in specs:
        register(name, spec)
        register(f"{package}/{name}", spec)


def load_package_dependencies(package: str, load_recursive: bool = False) -> None:
    """Register the messages of the packages that a package needs.

    Args:
        package: the package.
        load_recursive: whether those that these need count, too; else the package must have a manifest.xml.

    Raises:
        InvalidROSPkgException: there is no such package or manifest.
    """
    _begin()
    if load_recursive:
        from rospkg import RosPack

        needed = RosPack.get_instance().get_depends(package, implicit=True)
    else:
        from roslib.manifest import manifest_file, parse_file

        needed = [each.package for each in parse_file(str(manifest_file(package, True))).depends]
    for other in needed:
        if other in _loaded or other == package:
            continue
        _loaded.add(other)
        for name, spec in _specs_of(other):
            register(name, spec)


def _specs_of(package: str) -> list[tuple[str, MsgSpec]]:
    from roslib.packages import get_pkg_dir

    if not list_msg_types(package, False):
        get_pkg_dir(package)
    return get_pkg_msg_specs(package)[0]


def is_registered(msg_type_name: str) -> bool:
    """Return whether a definition has been registered."""
    return msg_type_name in REGISTERED_TYPES


def get_registered(msg_type_name: str, default_package: str | None = None) -> _MsgSpec:
    """Return a definition, registered or not; raises KeyError if there is none."""
    full = f"{default_package}/{msg_type_name}" if default_package else msg_type_name
    for name in (msg_type_name, full):
        if name in REGISTERED_TYPES:
            return REGISTERED_TYPES[name]
    try:
        return load_by_type(msg_type_name, default_package or "")[1]
    except MsgSpecException as error:
        raise KeyError(full) from error


def list_msg_types(package: str, include_depends: bool) -> Any:
    """Return the short names of a package's messages.

    Args:
        package: the package.
        include_depends: whether those of the packages that it needs count, too, as ``package/Type``.
    """
    names = list(finder().library.messages(package))
    if include_depends:
        from rospkg import RosPack

        for other in RosPack.get_instance().get_depends(package):
            names += [f"{other}/{short}" for short in finder().library.messages(other)]
    return names


def msg_file(package: str, type_: str) -> str:
    """Return the path that a message's definition has in its package."""
    from roslib.packages import resource_file

    return resource_file(package, "msg", type_ + EXT)


def get_pkg_msg_specs(package: str) -> tuple[list[tuple[str, MsgSpec]], list[str]]:
    """Return (full name, definition) of a package's messages, and the short names of those that are wrong."""
    good, bad = [], []
    for short in list_msg_types(package, False):
        try:
            good.append((f"{package}/{short}", load_by_type(short, package)[1]))
        except MsgSpecException:
            bad.append(short)
    return good, bad
