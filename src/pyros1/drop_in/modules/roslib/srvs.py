"""Definitions of services, from before genmsg."""

from __future__ import annotations

import os
from typing import Any

from genmsg.base import COMMENTCHAR, IODELIM, SEP, InvalidMsgSpec
from genmsg.msg_loader import MsgContext, load_srv_from_string
from genmsg.srvs import SrvSpec

from pyros1.drop_in.missing import missing
from pyros1.ground.errors import MessageError
from pyros1.ground.generated import finder
from roslib import msgs

EXT = ".srv"
VERBOSE = False
SrvSpecException = InvalidMsgSpec

__getattr__ = missing(__name__)


def is_verbose() -> bool:
    """Return what `set_verbose` told."""
    return VERBOSE


def set_verbose(v: bool) -> None:
    """Tell whether progress is shown; there is none to show."""
    global VERBOSE  # noqa: PLW0603
    VERBOSE = v


def load_from_string(text: str, package_context: str = "", full_name: str = "", short_name: str = "") -> SrvSpec:
    """Return the service's definition in a text; raises SrvSpecException."""
    parsed = load_srv_from_string(MsgContext(), text, f"{package_context or 'none'}/{short_name or 'Type'}")
    request, response = (
        msgs.load_from_string(part.text, package_context, f"{full_name}{kind}", f"{short_name}{kind}")
        for part, kind in ((parsed.request, "Request"), (parsed.response, "Response"))
    )
    spec = SrvSpec(request, response, text)
    spec.full_name, spec.short_name, spec.package = full_name, short_name, package_context
    return spec


def load_from_file(file_name: str, package_context: str = "") -> tuple[str, SrvSpec]:
    """Return name and definition of a service in a file; the name is without a package if none is given."""
    short = os.path.basename(file_name).removesuffix(EXT)
    name = f"{package_context}/{short}" if package_context else short
    with open(file_name, encoding="utf-8") as file:
        return name, load_from_string(file.read(), package_context, name, short)


def list_srv_types(package: str, include_depends: bool) -> Any:
    """Return the short names of a package's services; arguments as for `roslib.msgs.list_msg_types`."""
    names = list(finder().library.services(package))
    if include_depends:
        from rospkg import RosPack

        for other in RosPack.get_instance().get_depends(package):
            names += [f"{other}/{short}" for short in finder().library.services(other)]
    return names


def srv_file(package: str, type_: str) -> str:
    """Return the path that a service's definition has in its package."""
    from roslib.packages import resource_file

    return resource_file(package, "srv", type_ + EXT)


def get_pkg_srv_specs(package: str) -> tuple[list[tuple[str, SrvSpec]], list[str]]:
    """Return (name, definition) of a package's services, and the names of those that are wrong."""
    good, bad = [], []
    for short in list_srv_types(package, False):
        try:
            text = finder().library.service(f"{package}/{short}").text
            good.append((f"{package}/{short}", load_from_string(text, package, f"{package}/{short}", short)))
        except (MessageError, SrvSpecException):
            bad.append(short)
    return good, bad
