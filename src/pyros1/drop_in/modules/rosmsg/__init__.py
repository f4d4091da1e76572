"""rosmsg, by pyros1: definitions of messages and services (https://wiki.ros.org/rosmsg)."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from typing import Any

from genpy.message import strify_message

from pyros1.drop_in.commands import main as _main
from pyros1.drop_in.module_attributes import module_hooks
from pyros1.ground.errors import DefinitionError, UnknownTypeError
from pyros1.ground.msgs_imports import finder
from pyros1.msgs.digest import Digests
from pyros1.msgs.spec import MessageSpec

_PROTOTYPE = "see the command `rosmsg-proto`"
__getattr__, __dir__ = module_hooks(
    __name__,
    missing_reasons=dict.fromkeys(
        (
            *("construct_ordered_mapping", "construct_yaml_map_with_ordered_dict", "init_rosmsg_proto"),
            *("represent_ordered_mapping", "rosmsg_cmd_prototype"),
        ),
        _PROTOTYPE,
    ),
)

MODE_MSG = ".msg"
MODE_SRV = ".srv"
_MAX_LINES = 100_000


class ROSMsgException(Exception):
    """A type is not known, or its definition is invalid."""


class RosMsgProtoException(Exception):
    """The tool rosmsg-proto has failed. This class is only for programs that refer to it."""


class RosMsgProtoArgsException(Exception):
    """The tool rosmsg-proto has failed. This class is only for programs that refer to it."""


def _definition_library() -> Any:
    return finder().library


# Lists ---------------------------------------------------------------------------------------------------------------


def list_types(package: str, mode: str = MODE_MSG, rospack: Any = None) -> list[str]:
    """Return the full names of a package's types, sorted.

    Raises:
        ValueError: `mode` is neither `MODE_MSG` nor `MODE_SRV`.
        rospkg.ResourceNotFound: there is no such package.
    """
    if mode not in (MODE_MSG, MODE_SRV):
        raise ValueError(f"Unknown mode for list_types: {mode}")
    library = _definition_library()
    if not library.has_package(package):
        import rospkg

        (rospack or rospkg.RosPack()).get_path(package)  # raises an error if the package does not exist
        return []
    return [f"{package}/{name}" for name in _type_names(library, package, mode)]


def _type_names(library: Any, package: str, mode: str) -> list[str]:
    return sorted(library.messages(package) if mode == MODE_MSG else library.services(package))


def list_msgs(package: str, rospack: Any = None) -> list[str]:
    """Return the full names of a package's messages."""
    return list_types(package, MODE_MSG, rospack)


def list_srvs(package: str, rospack: Any = None) -> list[str]:
    """Return the full names of a package's services."""
    return list_types(package, MODE_SRV, rospack)


def _msg_filter(ext: str) -> Callable[[str], bool]:
    return lambda path: os.path.isfile(path) and path.endswith(ext)


def _list_types(path: str, subdir: str, ext: str) -> list[str]:
    """Return the names of the types that a folder defines, sorted, without the extension."""
    del subdir
    try:
        names = os.listdir(path)
    except OSError:
        return []
    return sorted(
        name[: -len(ext)] for name in names if name.endswith(ext) and os.path.isfile(os.path.join(path, name))
    )


def iterate_packages(rospack: Any, mode: str) -> Iterator[tuple[str, str]]:
    """Yield each package that defines types, with the folder that contains the definitions."""
    if mode not in (MODE_MSG, MODE_SRV):
        raise ValueError(f"Unknown mode for iterate_packages: {mode}")
    library = _definition_library()
    for package in library.packages():
        for folder in library.folders(package):
            subfolder = os.path.join(folder, mode[1:])
            definition_folder = subfolder if os.path.isdir(subfolder) else folder
            if _list_types(definition_folder, mode[1:], mode):
                yield package, definition_folder


def rosmsg_search(rospack: Any, mode: str, base_type: str) -> Iterator[str]:
    """Yield the full names of all types that have a given bare name."""
    library = _definition_library()
    for package in library.packages():
        if base_type in _type_names(library, package, mode):
            yield f"{package}/{base_type}"


# Definitions ---------------------------------------------------------------------------------------------------------


def spec_to_str(msg_context: Any, spec: Any, buff: Any = None, indent: str = "") -> str:
    """Return a definition with its nested types' definitions, as ``rosmsg show`` prints it.

    Args:
        msg_context: a genmsg.MsgContext with the nested types.
        spec: a genmsg.MsgSpec, or a `pyros1.msgs.spec.MessageSpec`, which needs no context.
        buff: a file to which the text is also written; None for no file.
        indent: prefix of each line.

    Raises:
        ROSMsgException: the text would be too long.
    """
    if isinstance(spec, MessageSpec):
        Digests(_definition_library().message).dependencies(spec)  # raises an error if a type contains itself
        lines = _lines(spec, indent, [_MAX_LINES])
    else:
        lines = _registered_lines(msg_context, spec, indent, [_MAX_LINES])
    text = "".join(f"{line}\n" for line in lines)
    if buff is not None:
        buff.write(text)
    return text


def _lines(spec: MessageSpec, indent: str, remaining: list[int]) -> Iterator[str]:
    for constant in spec.constants:
        yield f"{indent}{constant.type} {constant.name}={constant.text}"
    for field in spec.fields:
        remaining[0] -= 1
        if remaining[0] < 0:
            raise ROSMsgException(f"more than {_MAX_LINES} lines with all nested types")
        yield f"{indent}{field.type} {field.name}"
        if not field.is_builtin:
            yield from _lines(_definition_library().message(field.base), indent + "  ", remaining)


def _registered_lines(context: Any, spec: Any, indent: str, remaining: list[int]) -> Iterator[str]:
    from genmsg.msgs import bare_msg_type, is_builtin

    for constant in spec.constants:
        yield f"{indent}{constant.type} {constant.name}={constant.val}"
    for type_name, name in zip(spec.types, spec.names, strict=True):
        remaining[0] -= 1
        if remaining[0] < 0:
            raise ROSMsgException(f"more than {_MAX_LINES} lines with all nested types")
        yield f"{indent}{type_name} {name}"
        base = bare_msg_type(type_name) or ""
        if not is_builtin(base):
            nested = context.get_registered(base)
            yield from _registered_lines(context, nested, indent + "  ", remaining)


def get_msg_text(type_: str, raw: bool = False, rospack: Any = None) -> str:
    """Return the text of a message's definition: as written if ``raw``, otherwise with all nested types.

    Raises:
        ROSMsgException: there is no such type, or its definition is invalid.
    """
    name = "std_msgs/Header" if type_ == "Header" else type_
    try:
        spec = _definition_library().message(name)
        return str(spec.text) if raw else spec_to_str(None, spec)
    except (DefinitionError, UnknownTypeError) as error:
        raise ROSMsgException(f"Unable to load msg [{type_}]: {error}") from error


def get_srv_text(type_: str, raw: bool = False, rospack: Any = None) -> str:
    """Return the text of a service's definition; see `get_msg_text` for the arguments and errors."""
    try:
        spec = _definition_library().service(type_)
        return (
            str(spec.text) if raw else "---\n".join(spec_to_str(None, part) for part in (spec.request, spec.response))
        )
    except (DefinitionError, UnknownTypeError) as error:
        raise ROSMsgException(f"Unknown srv type [{type_}]: {error}") from error


def rosmsg_md5(mode: str, type_: str) -> str:
    """Return the md5 sum of a type; raises IOError if it cannot be loaded."""
    try:
        cls = finder().message(type_) if mode == MODE_MSG else finder().service(type_)
    except (DefinitionError, UnknownTypeError):
        raise OSError(f"cannot load [{type_}]") from None
    return str(cls._md5sum)


def rosmsg_debug(rospack: Any, mode: str, type_: str, raw: bool = False) -> None:
    """Print the text of a definition."""
    if mode not in (MODE_MSG, MODE_SRV):
        raise ROSMsgException(f"Unknown mode for rosmsg_debug: {mode}")
    print((get_msg_text if mode == MODE_MSG else get_srv_text)(type_, raw=raw, rospack=rospack))


def get_yaml_for_msg(
    msg: Any,
    prefix: str = "",
    time_offset: Any = None,
    current_time: Any = None,
    field_filter: Any = None,
    flow_style_: Any = None,
    fill_arrays_: bool = False,
) -> str:
    """Return a message as YAML."""
    return strify_message(msg, prefix, time_offset=time_offset, current_time=current_time)


def get_array_type_instance(field_type: str, default_package: str | None = None) -> Any:
    """Return a new message of an array's element type; None for numbers and strings."""
    base = field_type.partition("[")[0]
    if "/" not in base and default_package:
        base = f"{default_package}/{base}"
    try:
        return finder().message(base)() if "/" in base else None
    except (DefinitionError, UnknownTypeError):
        return None


def create_names_filter(names: Any) -> Callable[[Any], Iterator[str]]:
    """Return a function that yields the names of a message's fields, except the ones in ``names``."""
    return lambda message: (name for name in message.__slots__ if name not in names)


# The tool ------------------------------------------------------------------------------------------------------------


def _run_command(mode: str, verb: str, words: list[str]) -> None:
    _main("rosmsg" if mode == MODE_MSG else "rossrv", ["", verb, *words])


def rosmsg_cmd_show(mode: str, full: str, alias: str = "show") -> None:
    """Print definitions; the types are on the process's command line."""
    _run_command(mode, alias, sys.argv[2:])


def rosmsg_cmd_md5(mode: str, full: str) -> None:
    """Print md5 sums; the types are on the process's command line."""
    _run_command(mode, "md5", sys.argv[2:])


def rosmsg_cmd_list(mode: str, full: str, argv: list[str] | None = None) -> None:
    """Print all types."""
    _run_command(mode, "list", (sys.argv[1:] if argv is None else argv)[1:])


def rosmsg_cmd_package(mode: str, full: str) -> None:
    """Print the types of a package, which is on the process's command line."""
    _run_command(mode, "package", sys.argv[2:])


def rosmsg_cmd_packages(mode: str, full: str, argv: list[str] | None = None) -> None:
    """Print the packages with types."""
    _run_command(mode, "packages", (sys.argv[1:] if argv is None else argv)[1:])


def fullusage(mode: str) -> str:
    """Return the help of the tool: rosmsg for `MODE_MSG`, else rossrv."""
    tool, kind = ("rosmsg", "Message") if mode == MODE_MSG else ("rossrv", "Service")
    noun = kind.lower()
    verbs = {
        "show": f"Show {noun} description",
        "info": f"Alias for {tool} show",
        "list": f"List all {noun}s",
        "md5": f"Display {noun} md5sum",
        "package": f"List {noun}s in a package",
        "packages": f"List packages that contain {noun}s",
    }
    lines = "".join(f"\t{tool} {verb}\t{text}\n" for verb, text in verbs.items())
    return (
        f"{tool} is a command-line tool for displaying information about ROS {kind} types.\n\n"
        f"Commands:\n{lines}\nType {tool} <command> -h for more detailed usage\n"
    )


def rosmsgmain(mode: str = MODE_MSG) -> None:
    """Run the tool with the process's command line."""
    if mode not in (MODE_MSG, MODE_SRV):
        raise ROSMsgException(f"Unknown mode: {mode}")
    _main("rosmsg" if mode == MODE_MSG else "rossrv", sys.argv)
