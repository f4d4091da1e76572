"""roslib's names for genmsg's message definitions."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable

from genmsg.base import COMMENTCHAR, CONSTCHAR, SEP, InvalidMsgSpec
from genmsg.msg_loader import MsgContext, load_msg_from_string
from genmsg.msgs import (
    BUILTIN_TYPES,
    DURATION,
    HEADER,
    PRIMITIVE_TYPES,
    TIME,
    Constant,
    Field,
    MsgSpec,
    is_builtin,
    is_header_type,
    is_valid_constant_type,
    is_valid_msg_field_name,
    is_valid_msg_type,
    resolve_type,
)
from genmsg.msgs import bare_msg_type as base_msg_type
from genmsg.msgs import parse_type as _parse_type

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground.errors import MessageError
from pyros1.ground.msgs_imports import finder

_NO_PACKAGE = "none"
EXT = ".msg"
MsgSpecException = InvalidMsgSpec

_REASON = "definitions are found when they are used; see load_by_type and genmsg.MsgContext"

__getattr__ = module_getattr(
    __name__,
    REGISTERED_TYPES=_REASON,
    register=_REASON,
    get_registered=_REASON,
    load_package=_REASON,
    load_package_dependencies=_REASON,
)


def parse_type(type_: str) -> tuple[str, bool, int | None]:
    """Return a type without brackets, whether it is an array, and its length; raises MsgSpecException if the type is
    not legal.
    """
    try:
        return _parse_type(type_)
    except ValueError as error:
        raise MsgSpecException(str(error)) from None


def load_from_string(text: str, package_context: str = "", full_name: str = "", short_name: str = "") -> MsgSpec:
    """Parse a definition; raises MsgSpecException if it is invalid."""
    package = package_context or _NO_PACKAGE
    spec = load_msg_from_string(MsgContext(), text, f"{package}/{short_name or 'Type'}")
    types = [name.removeprefix(f"{_NO_PACKAGE}/") for name in spec.types]
    if re.search(r"^\s*Header\b", text, re.MULTILINE):  # keep the type as it is written
        types = [name.replace("std_msgs/Header", HEADER) for name in types]
    spec = MsgSpec(types, spec.names, spec.constants, text, full_name)
    spec.short_name, spec.package = short_name, package_context
    return spec


def load_from_file(file_path: str, package_context: str = "") -> tuple[str, MsgSpec]:
    """Return name and definition of the message in a file; the name has no package if ``package_context`` is empty."""
    short = os.path.basename(file_path).removesuffix(EXT)
    name = f"{package_context}/{short}" if package_context else short
    with open(file_path, encoding="utf-8") as file:
        return name, load_from_string(file.read(), package_context, name, short)


def load_by_type(msgtype: str, package_context: str = "") -> tuple[str, MsgSpec]:
    """Return name and definition of a message; raises MsgSpecException if the definition is missing or invalid."""
    name = msgtype if SEP in msgtype else f"{package_context}/{msgtype}"
    try:
        text = finder().library.message(name).text
    except MessageError as error:
        raise MsgSpecException(str(error)) from error
    package, _, short = name.partition(SEP)
    return name, load_from_string(text, package, name, short)


def list_msg_types(package: str, include_depends: bool) -> list[str]:
    """Return the short names of a package's messages.

    Args:
        package: the package.
        include_depends: whether to add the messages of the package's dependencies, as ``package/Type``.
    """
    return list_types(finder().library.messages, package, include_depends)


def list_types(types: Callable[[str], Iterable[str]], package: str, include_depends: bool) -> list[str]:
    """Return the types of a package; see `list_msg_types`. ``types`` is called with a package, and returns its
    types.
    """
    names = list(types(package))
    if include_depends:
        from rospkg import RosPack

        names += [f"{other}/{name}" for other in RosPack.get_instance().get_depends(package) for name in types(other)]
    return names


def msg_file(package: str, type_: str) -> str:
    """Return the path of the file that defines a message; raises InvalidROSPkgException."""
    from roslib.packages import resource_file

    return resource_file(package, "msg", type_ + EXT)
