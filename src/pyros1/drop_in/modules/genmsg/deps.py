"""Files that a definition uses."""

from __future__ import annotations

from genmsg.base import InvalidMsgSpec
from genmsg.gentools import compute_full_type_name
from genmsg.msg_loader import MsgContext, SearchPath, load_depends, load_msg_from_file, load_srv_from_file
from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)

_Pairs = list[tuple[str, str]]


def find_msg_dependencies_with_type(pkg_name: str, msg_file: str, search_paths: SearchPath) -> _Pairs:
    """Return (type, file) of all definitions that the message in a file uses.

    Args:
        pkg_name: its package.
        msg_file: its file.
        search_paths: package -> folders.

    Raises:
        MsgNotFound, InvalidMsgSpec: a definition is missing or wrong.
    """
    context = MsgContext.create_default()
    name = compute_full_type_name(pkg_name, msg_file.rpartition("/")[2])
    load_depends(context, load_msg_from_file(context, msg_file, name), search_paths)
    return _files(context, context.get_all_depends(name))


def find_msg_dependencies(pkg_name: str, msg_file: str, search_paths: SearchPath) -> list[str]:
    """Return the files of all definitions that the message in a file uses."""
    return [path for _, path in find_msg_dependencies_with_type(pkg_name, msg_file, search_paths)]


def find_srv_dependencies_with_type(pkg_name: str, msg_file: str, search_paths: SearchPath) -> _Pairs:
    """Return (type, file) of all definitions that the service in a file uses; as for messages."""
    context = MsgContext.create_default()
    name = compute_full_type_name(pkg_name, msg_file.rpartition("/")[2])
    spec = load_srv_from_file(context, msg_file, name)
    load_depends(context, spec, search_paths)
    names = [each for part in (spec.request, spec.response) for each in context.get_all_depends(part.full_name)]
    return _files(context, names)


def find_srv_dependencies(pkg_name: str, msg_file: str, search_paths: SearchPath) -> list[str]:
    """Return the files of all definitions that the service in a file uses."""
    return [path for _, path in find_srv_dependencies_with_type(pkg_name, msg_file, search_paths)]


def _files(context: MsgContext, names: list[str]) -> _Pairs:
    return [(name, context.get_file(name) or "") for name in dict.fromkeys(names)]
