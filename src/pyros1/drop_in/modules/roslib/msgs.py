"""Definitions of messages, from before genmsg."""

from __future__ import annotations

import os
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

from pyros1.drop_in.missing import missing
from pyros1.ground.errors import MessageError
from pyros1.ground.generated import finder

EXT = ".msg"
VERBOSE = False
RESERVED_TYPES = [*BUILTIN_TYPES, HEADER]
EXTENDED_BUILTINS = {name: MsgContext.create_default().get_registered(name) for name in (TIME, DURATION)}
MsgSpecException = InvalidMsgSpec

_WHY = "definitions are found when they are used; nothing is registered"

__getattr__ = missing(__name__, register=_WHY, reinit=_WHY, load_package=_WHY, load_package_dependencies=_WHY)


def is_verbose() -> bool:
    """Return whether progress is shown: it is not."""
    return VERBOSE


def set_verbose(v: bool) -> None:
    """Tell whether progress is shown; there is none to show."""


def parse_type(type_: str) -> tuple[str, bool, int | None]:
    """Return a type without brackets, whether it is an array, and its length; raises MsgSpecException."""
    try:
        return _parse_type(type_)
    except ValueError as error:
        raise MsgSpecException(str(error)) from None


def load_from_string(text: str, package_context: str = "", full_name: str = "", short_name: str = "") -> MsgSpec:
    """Return the definition in a text; raises MsgSpecException."""
    package = package_context or "none"
    spec = load_msg_from_string(MsgContext(), text, full_name or f"{package}/{short_name or 'Type'}")
    spec.full_name, spec.short_name, spec.package = full_name, short_name, package_context
    return spec


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


def is_registered(msg_type_name: str) -> bool:
    """Return whether a definition has been registered: none is."""
    return False


def get_registered(msg_type_name: str, default_package: str | None = None) -> MsgSpec:
    """Return a definition; raises KeyError if there is none."""
    try:
        return load_by_type(msg_type_name, default_package or "")[1]
    except MsgSpecException as error:
        raise KeyError(msg_type_name) from error


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
    """Return (name, definition) of a package's messages, and the names of those that are wrong."""
    good, bad = [], []
    for short in list_msg_types(package, False):
        try:
            good.append((short, load_by_type(short, package)[1]))
        except MsgSpecException:
            bad.append(short)
    return good, bad
