"""Finds the candidates that completion offers: running nodes and topics, installed packages and types, files ..."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pyros1.cli.complete_line import CommandLine
    from pyros1.net.master_client import MasterClient

_LISTEN_SECONDS = 0.25
"""Seconds to listen for frames."""


@contextmanager
def _connect_to_master() -> Iterator[MasterClient]:
    """Yield a client for the master.

    The client's timeout does not cover looking up host names. Therefore, a timer ends the process if the client is in
    use for longer than `MASTER_TIMEOUT`.
    """
    from pyros1.cli.complete_line import MASTER_TIMEOUT  # noqa: PLC0415
    from pyros1.net.hosts import master_uri  # noqa: PLC0415
    from pyros1.net.master_client import MasterClient  # noqa: PLC0415

    alarm = threading.Timer(MASTER_TIMEOUT, os._exit, [0])
    alarm.daemon = True
    alarm.start()
    client = MasterClient("/complete", master_uri(os.environ, {}), timeout=MASTER_TIMEOUT)
    try:
        yield client
    finally:
        alarm.cancel()
        client.close()


# Running system -------------------------------------------------------------------------------------------------------


def _topics(_: CommandLine) -> list[str]:
    with _connect_to_master() as master:
        publishers, subscribers, _services = master.get_system_state()
    return sorted({name for name, _ in [*publishers, *subscribers]})


def _services(_: CommandLine) -> list[str]:
    with _connect_to_master() as master:
        return sorted(name for name, _ in master.get_system_state()[2])


def _nodes(_: CommandLine) -> list[str]:
    with _connect_to_master() as master:
        return sorted({node for table in master.get_system_state() for _, nodes in table for node in nodes})


def _reconfigurable_nodes(line: CommandLine) -> list[str]:
    return [name.removesuffix("/set_parameters") for name in _services(line) if name.endswith("/set_parameters")]


def _parameters(_: CommandLine) -> list[str]:
    with _connect_to_master() as master:
        return sorted(master.get_param_names())


def _namespaces(line: CommandLine) -> list[str]:
    names = _nodes(line) if line.command == "node" else _services(line) if line.command == "service" else _topics(line)
    return sorted(
        {name[:position] for name in names for position, character in enumerate(name) if character == "/" and position}
    )


def _machines(_: CommandLine) -> list[str]:
    from urllib.parse import urlsplit  # noqa: PLC0415

    with _connect_to_master() as master:
        nodes = {node for table in master.get_system_state() for _, nodes in table for node in nodes}
        return sorted({urlsplit(master.lookup_node(node)).hostname or "" for node in nodes})


def _topic_type(line: CommandLine) -> list[str]:
    """Return the topic's type, or all message types if the topic has no type yet or no master is running."""
    from pyros1.ground.errors import Error  # noqa: PLC0415

    try:
        with _connect_to_master() as master:
            types = {topic: type_name for topic, type_name in master.get_topic_types()}  # noqa: C416 - pairs are lists
    except Error:
        types = {}
    name = line.positional_arguments[0]
    topic_type = types.get(name if name.startswith("/") else "/" + name)
    return [topic_type] if topic_type and topic_type != "*" else _types(line, "msg")


def _frames(_: CommandLine) -> list[str]:
    """Return the frames received within `_LISTEN_SECONDS`: static frames and frequently published ones."""
    from time import sleep  # noqa: PLC0415

    with _connect_to_master() as master:
        if not {topic for topic, _ in master.get_system_state()[0]} & {"/tf", "/tf_static"}:
            return []
        from pyros1.node import Node  # noqa: PLC0415 - only needed if frames are published
        from pyros1.tf.buffer import Buffer  # noqa: PLC0415
        from pyros1.tf.listener import TransformListener  # noqa: PLC0415

        buffer = Buffer()
        with Node("complete", anonymous=True, rosout=False, handle_signals=False, log_level="fatal") as node:
            TransformListener(node, buffer)
            sleep(_LISTEN_SECONDS)
        return sorted(buffer.frames())


# Installed packages and types -----------------------------------------------------------------------------------------


def _types(line: CommandLine, extension: str) -> list[str]:
    """Return the types in the package at the cursor. If several packages match, return their names with a slash."""
    from pyros1.finding.library import Library  # noqa: PLC0415

    library = Library(os.environ)
    package, has_slash, _ = line.token.partition("/")
    if has_slash:
        names = library.messages(package) if extension == "msg" else library.services(package)
        return [f"{package}/{name}" for name in names]
    matching = [name for name in library.packages() if name.startswith(package)]
    if len(matching) == 1:
        names = library.messages(matching[0]) if extension == "msg" else library.services(matching[0])
        return [f"{matching[0]}/{name}" for name in names]
    return [f"{name}/" for name in matching]


def _message_types(line: CommandLine) -> list[str]:
    return _types(line, "msg")


def _service_types(line: CommandLine) -> list[str]:
    return _types(line, "srv")


def _message_template(line: CommandLine) -> list[str]:
    return [_template("msg", line.positional_arguments[1], line.one_line)]


def _request_template(line: CommandLine) -> list[str]:
    from pyros1.graph import probe_service  # noqa: PLC0415

    name = (
        line.positional_arguments[0]
        if line.positional_arguments[0].startswith("/")
        else "/" + line.positional_arguments[0]
    )
    with _connect_to_master() as master:
        type_name = probe_service(name, master.lookup_service(name), "/complete", timeout=0.5)["type"]
    return [_template("srv", type_name, line.one_line)]


def _template(extension: str, type_name: str, one_line: bool) -> str:
    from pyros1.cli.commands.msg_proto import load_class  # noqa: PLC0415
    from pyros1.observe.template import template  # noqa: PLC0415

    return template(load_class(extension, type_name), 1 if one_line else None)


def _definition_kinds(_: CommandLine) -> list[str]:
    return ["msg", "srv"]


def _definitions(line: CommandLine) -> list[str]:
    return _types(line, line.positional_arguments[0])


def _example_names(_: CommandLine) -> list[str]:
    from pyros1.guide.catalogue import CATALOGUE  # noqa: PLC0415

    return [example.name for example in CATALOGUE]


def _guide_arguments(line: CommandLine) -> list[str]:
    from pyros1.guide import documents  # noqa: PLC0415

    if line.words == ["howto"]:
        return list(documents.pages())
    return [str(step.number) for step in documents.steps()] + ["check", "howto"] * (not line.words)


def _packages(_: CommandLine) -> list[str]:
    from pyros1.finding.crawl import all_packages  # noqa: PLC0415

    return sorted({found.name for found in all_packages(os.environ)})


def _package_folders(line: CommandLine) -> list[str]:
    """Return the subfolders of the folder typed so far, or, before the first slash, special names such as ``log``."""
    from pyros1.cli.commands.pkg._files import resolve_folder, special_folders  # noqa: PLC0415
    from pyros1.finding.packages import is_folder  # noqa: PLC0415

    folder, slash, _ = line.token.rpartition("/")
    if not slash:
        return sorted(special_folders())
    with os.scandir(resolve_folder(folder)) as entries:
        return sorted(f"{folder}/{entry.name}/" for entry in entries if entry.name[0] != "." and is_folder(entry))


def _package_files(line: CommandLine) -> list[str]:
    from pyros1.cli.commands.pkg._files import resolve_folder  # noqa: PLC0415
    from pyros1.finding.packages import files_below  # noqa: PLC0415

    return sorted({name for _, files in files_below(resolve_folder(line.positional_arguments[0])) for name in files})


def _executables(line: CommandLine) -> list[str]:
    from pyros1.finding.packages import PackageIndex  # noqa: PLC0415

    return PackageIndex(os.environ).executables(line.positional_arguments[0])


# Files ----------------------------------------------------------------------------------------------------------------


def _files(line: CommandLine, *suffixes: str) -> list[str]:
    from pyros1.finding.packages import is_folder  # noqa: PLC0415

    folder, slash, name_start = line.token.rpartition("/")
    result = []
    with os.scandir(os.path.expanduser(folder) or slash or ".") as entries:
        for entry in entries:
            if entry.name.startswith(".") and not name_start.startswith("."):
                continue
            if is_folder(entry):
                result.append(f"{folder}{slash}{entry.name}/")
            elif not suffixes or entry.name.endswith(suffixes):
                result.append(f"{folder}{slash}{entry.name}")
    return sorted(result)


def _bags(line: CommandLine) -> list[str]:
    return _files(line, ".bag", ".active")


def _launch_files(line: CommandLine) -> list[str]:
    return _files(line, ".launch", ".test", ".xml")


def _package_launch_files(line: CommandLine) -> list[str]:
    if os.path.isfile(line.positional_arguments[0]):
        return []
    return [name for name in _package_files(line) if name.endswith((".launch", ".test"))]


def _launch_args(line: CommandLine) -> list[str]:
    """Return the arguments of the launch file in the form ``name:=``."""
    from pyros1.launch.reading.cli_arguments import find_launch_files  # noqa: PLC0415
    from pyros1.launch.reading.loader import load_plan  # noqa: PLC0415
    from pyros1.launch.reading.system_resources import make_resources  # noqa: PLC0415

    if not os.path.isfile(line.positional_arguments[0]) and len(line.positional_arguments) < 2:
        return []
    resources = make_resources()
    plan = load_plan(find_launch_files(line.positional_arguments, resources)[:1], {}, resources, only_args=True)
    return sorted(f"{name}:=" for name in plan.args)


def _throttle_units(_: CommandLine) -> list[str]:
    return ["messages", "bytes"]


def _panels(line: CommandLine) -> list[str]:
    from pyros1.cli.shared.gui_programs import GUI_PROGRAMS, PANEL_PARTS  # noqa: PLC0415
    from pyros1.web.server.assets import Assets  # noqa: PLC0415

    return sorted([*Assets().panels, *PANEL_PARTS]) + [*GUI_PROGRAMS] * bool(line.token)


def _panel_arguments(line: CommandLine) -> list[str]:
    """Return the candidates for the argument of a panel, such as the topics for the image panel."""
    from pyros1.cli.shared.gui_programs import GUI_PROGRAMS  # noqa: PLC0415

    panel = line.positional_arguments[0]
    panel = GUI_PROGRAMS[panel].args[0] if panel in GUI_PROGRAMS else panel
    providers = {
        "bag": _bags, "image": _topics, "launches": _nodes, "nodes": _nodes, "plot": _topics, "publisher": _topics,
        "reconfigure": _reconfigurable_nodes, "scene": _files, "services": _services, "topics": _topics,
        "turtles": _nodes,
    }  # fmt: skip
    return providers[panel](line) if panel in providers else []


PROVIDERS_BY_KIND: dict[str, Callable[[CommandLine], list[str]]] = {
    "bag": _bags,
    "reconfigurable_node": _reconfigurable_nodes,
    "definition": _definitions,
    "definition_kind": _definition_kinds,
    "example": _example_names,
    "executable": _executables,
    "file": _files,
    "frame": _frames,
    "guide": _guide_arguments,
    "launch_arg": _launch_args,
    "launch_file": _launch_files,
    "machine": _machines,
    "message_type": _message_types,
    "message_template": _message_template,
    "namespace": _namespaces,
    "node": _nodes,
    "package": _packages,
    "package_file": _package_files,
    "package_launch_file": _package_launch_files,
    "panel": _panels,
    "panel_argument": _panel_arguments,
    "param": _parameters,
    "package_folder": _package_folders,
    "request_template": _request_template,
    "service": _services,
    "service_type": _service_types,
    "throttle_unit": _throttle_units,
    "topic": _topics,
    "topic_type": _topic_type,
}
"""The functions that return the candidates, by kind of argument."""
