"""roslib's names for genmsg's service definitions."""

from __future__ import annotations

import os

from genmsg.base import COMMENTCHAR, IODELIM, SEP, InvalidMsgSpec
from genmsg.msg_loader import MsgContext, load_srv_from_string
from genmsg.srvs import SrvSpec

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground.msgs_imports import finder
from roslib import msgs

EXT = ".srv"
SrvSpecException = InvalidMsgSpec

__getattr__ = module_getattr(__name__)


def load_from_string(text: str, package_context: str = "", full_name: str = "", short_name: str = "") -> SrvSpec:
    """Parse a service's definition; raises SrvSpecException if it is invalid."""
    parsed = load_srv_from_string(MsgContext(), text, f"{package_context or 'none'}/{short_name or 'Type'}")
    request, response = (
        msgs.load_from_string(message.text, package_context, f"{full_name}{suffix}", f"{short_name}{suffix}")
        for message, suffix in ((parsed.request, "Request"), (parsed.response, "Response"))
    )
    spec = SrvSpec(request, response, text)
    spec.full_name, spec.short_name, spec.package = full_name, short_name, package_context
    return spec


def load_from_file(file_name: str, package_context: str = "") -> tuple[str, SrvSpec]:
    """Return name and definition of the service in a file; the name has no package if ``package_context`` is empty."""
    short = os.path.basename(file_name).removesuffix(EXT)
    name = f"{package_context}/{short}" if package_context else short
    with open(file_name, encoding="utf-8") as file:
        return name, load_from_string(file.read(), package_context, name, short)


def list_srv_types(package: str, include_depends: bool) -> list[str]:
    """Return the short names of a package's services; see `roslib.msgs.list_msg_types`."""
    return msgs.list_types(finder().library.services, package, include_depends)


def srv_file(package: str, type_: str) -> str:
    """Return the path of the file that defines a service; raises InvalidROSPkgException."""
    from roslib.packages import resource_file

    return resource_file(package, "srv", type_ + EXT)
