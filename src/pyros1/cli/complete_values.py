"""The values that completion offers: what is running, what is installed, and files."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pyros1.cli.complete_line import Line
    from pyros1.net.master_client import MasterClient

_LISTEN_SECONDS = 0.25
"""Seconds to listen for frames."""


@contextmanager
def _master() -> Iterator[MasterClient]:
    """Yield the master. Host name lookups have no timeout, so a timer ends the process."""
    from pyros1.cli.complete_line import TIMEOUT  # noqa: PLC0415
    from pyros1.net.hosts import master_uri  # noqa: PLC0415
    from pyros1.net.master_client import MasterClient  # noqa: PLC0415

    alarm = threading.Timer(TIMEOUT, os._exit, [0])
    alarm.daemon = True
    alarm.start()
    client = MasterClient("/complete", master_uri(os.environ, {}), timeout=TIMEOUT)
    try:
        yield client
    finally:
        alarm.cancel()
        client.close()


# What runs ------------------------------------------------------------------------------------------------------------


def _topics(_: Line) -> list[str]:
    with _master() as master:
        publishers, subscribers, _services = master.get_system_state()
    return sorted({name for name, _ in [*publishers, *subscribers]})


def _services(_: Line) -> list[str]:
    with _master() as master:
        return sorted(name for name, _ in master.get_system_state()[2])


def _nodes(_: Line) -> list[str]:
    with _master() as master:
        return sorted({node for table in master.get_system_state() for _, nodes in table for node in nodes})


def _configurable(line: Line) -> list[str]:
    return [name.removesuffix("/set_parameters") for name in _services(line) if name.endswith("/set_parameters")]


def _params(_: Line) -> list[str]:
    with _master() as master:
        return sorted(master.get_param_names())


def _namespaces(line: Line) -> list[str]:
    names = _nodes(line) if line.command == "node" else _services(line) if line.command == "service" else _topics(line)
    return sorted({name[:i] for name in names for i, c in enumerate(name) if c == "/" and i})


def _machines(_: Line) -> list[str]:
    from urllib.parse import urlsplit  # noqa: PLC0415

    with _master() as master:
        nodes = {node for table in master.get_system_state() for _, nodes in table for node in nodes}
        return sorted({urlsplit(master.lookup_node(node)).hostname or "" for node in nodes})


def _topic_type(line: Line) -> list[str]:
    """Return the topic's type; all types if it has none yet, or no master is running."""
    from pyros1.ground.errors import Error  # noqa: PLC0415

    try:
        with _master() as master:
            known = {topic: kind for topic, kind in master.get_topic_types()}  # noqa: C416 - pairs are lists
    except Error:
        known = {}
    name = line.given_arguments[0]
    known_type = known.get(name if name.startswith("/") else "/" + name)
    return [known_type] if known_type and known_type != "*" else _types(line, "msg")


def _frames(_: Line) -> list[str]:
    """Return frames that are received immediately: all static ones, and those that are sent often."""
    from time import sleep  # noqa: PLC0415

    with _master() as master:
        if not {topic for topic, _ in master.get_system_state()[0]} & {"/tf", "/tf_static"}:
            return []
        from pyros1.node import Node  # noqa: PLC0415 - not needed without frames
        from pyros1.tf.buffer import Buffer  # noqa: PLC0415
        from pyros1.tf.listener import TransformListener  # noqa: PLC0415

        buffer = Buffer()
        with Node("complete", anonymous=True, rosout=False, handle_signals=False, log_level="fatal") as node:
            TransformListener(node, buffer)
            sleep(_LISTEN_SECONDS)
        return sorted(buffer.frames())


# What is installed ----------------------------------------------------------------------------------------------------


def _types(line: Line, kind: str) -> list[str]:
    """Return packages with a slash, or the types of the package that was typed."""
    from pyros1.finding.library import Library  # noqa: PLC0415

    library = Library(os.environ)
    package, slash, _ = line.token.partition("/")
    if slash:
        names = library.messages(package) if kind == "msg" else library.services(package)
        return [f"{package}/{name}" for name in names]
    chosen = [name for name in library.packages() if name.startswith(package)]
    if len(chosen) == 1:
        names = library.messages(chosen[0]) if kind == "msg" else library.services(chosen[0])
        return [f"{chosen[0]}/{name}" for name in names]
    return [f"{name}/" for name in chosen]


def _messages(line: Line) -> list[str]:
    return _types(line, "msg")


def _service_types(line: Line) -> list[str]:
    return _types(line, "srv")


def _message_text(line: Line) -> list[str]:
    return [_template("msg", line.given_arguments[1], line.one_line)]


def _request_text(line: Line) -> list[str]:
    from pyros1.graph import probe_service  # noqa: PLC0415

    name = line.given_arguments[0] if line.given_arguments[0].startswith("/") else "/" + line.given_arguments[0]
    with _master() as master:
        kind = probe_service(name, master.lookup_service(name), "/complete", timeout=0.5)["type"]
    return [_template("srv", kind, line.one_line)]


def _template(mode: str, name: str, one_line: bool) -> str:
    from pyros1.cli.commands.msg_proto import load  # noqa: PLC0415
    from pyros1.observe.template import template  # noqa: PLC0415

    return template(load(mode, name), 1 if one_line else None)


def _definition_kinds(_: Line) -> list[str]:
    return ["msg", "srv"]


def _definitions(line: Line) -> list[str]:
    return _types(line, line.given_arguments[0])


def _examples(_: Line) -> list[str]:
    from pyros1.guide.catalogue import CATALOGUE  # noqa: PLC0415

    return [each.name for each in CATALOGUE]


def _guide(line: Line) -> list[str]:
    from pyros1.guide import text  # noqa: PLC0415

    if line.words == ["howto"]:
        return list(text.pages())
    return [str(step.number) for step in text.steps()] + ["check", "howto"] * (not line.words)


def _packages(_: Line) -> list[str]:
    from pyros1.finding.crawl import all_packages  # noqa: PLC0415

    return sorted({found.name for found in all_packages(os.environ)})


def _package_places(line: Line) -> list[str]:
    """Return folders in a package, and special names of folders."""
    from pyros1.cli.commands.pkg._files import folder_of, special_places  # noqa: PLC0415
    from pyros1.finding.packages import is_folder  # noqa: PLC0415

    place, slash, _ = line.token.rpartition("/")
    if not slash:
        return sorted(special_places())
    with os.scandir(folder_of(place)) as entries:
        return sorted(f"{place}/{entry.name}/" for entry in entries if entry.name[0] != "." and is_folder(entry))


def _package_files(line: Line) -> list[str]:
    from pyros1.cli.commands.pkg._files import folder_of  # noqa: PLC0415
    from pyros1.finding.packages import files_below  # noqa: PLC0415

    return sorted({name for _, files in files_below(folder_of(line.given_arguments[0])) for name in files})


def _executables(line: Line) -> list[str]:
    from pyros1.finding.packages import PackageIndex  # noqa: PLC0415

    return PackageIndex(os.environ).executables(line.given_arguments[0])


# Files ----------------------------------------------------------------------------------------------------------------


def _files(line: Line, *endings: str) -> list[str]:
    from pyros1.finding.packages import is_folder  # noqa: PLC0415

    folder, slash, start = line.token.rpartition("/")
    result = []
    with os.scandir(os.path.expanduser(folder) or slash or ".") as entries:
        for entry in entries:
            if entry.name.startswith(".") and not start.startswith("."):
                continue
            if is_folder(entry):
                result.append(f"{folder}{slash}{entry.name}/")
            elif not endings or entry.name.endswith(endings):
                result.append(f"{folder}{slash}{entry.name}")
    return sorted(result)


def _bags(line: Line) -> list[str]:
    return _files(line, ".bag", ".active")


def _launch_files(line: Line) -> list[str]:
    return _files(line, ".launch", ".test", ".xml")


def _package_launch_files(line: Line) -> list[str]:
    if os.path.isfile(line.given_arguments[0]):
        return []
    return [name for name in _package_files(line) if name.endswith((".launch", ".test"))]


def _launch_args(line: Line) -> list[str]:
    """Return arguments of the file as ``name:=``, without those already given."""
    from pyros1.launch.reading.loader import load_plan  # noqa: PLC0415
    from pyros1.launch.reading.words import find_files  # noqa: PLC0415
    from pyros1.launch.reading.world import make_resources  # noqa: PLC0415

    if not os.path.isfile(line.given_arguments[0]) and len(line.given_arguments) < 2:
        return []
    resources = make_resources()
    plan = load_plan(find_files(line.given_arguments, resources)[:1], {}, resources, only_args=True)
    return sorted(f"{name}:=" for name in plan.args)


def _throttles(_: Line) -> list[str]:
    return ["messages", "bytes"]


def _panels(line: Line) -> list[str]:
    from pyros1.cli.shared.windows import PARTS, PROGRAMS  # noqa: PLC0415
    from pyros1.web.server.assets import Assets  # noqa: PLC0415

    return sorted([*Assets().panels, *PARTS]) + [*PROGRAMS] * bool(line.token)


def _panel_arguments(line: Line) -> list[str]:
    """Return the possible contents of a panel of the page."""
    from pyros1.cli.shared.windows import PROGRAMS  # noqa: PLC0415

    panel = line.given_arguments[0]
    panel = PROGRAMS[panel].words[0] if panel in PROGRAMS else panel
    makers = {
        "bag": _bags, "image": _topics, "launches": _nodes, "nodes": _nodes, "plot": _topics, "publisher": _topics,
        "reconfigure": _configurable, "scene": _files, "services": _services, "topics": _topics, "turtles": _nodes,
    }  # fmt: skip
    return makers[panel](line) if panel in makers else []


KINDS: dict[str, Callable[[Line], list[str]]] = {
    "bag": _bags,
    "configurable": _configurable,
    "definition": _definitions,
    "definition_kind": _definition_kinds,
    "example": _examples,
    "executable": _executables,
    "file": _files,
    "frame": _frames,
    "guide": _guide,
    "launch_arg": _launch_args,
    "launch_file": _launch_files,
    "machine": _machines,
    "message": _messages,
    "message_text": _message_text,
    "namespace": _namespaces,
    "node": _nodes,
    "package": _packages,
    "package_file": _package_files,
    "package_launch_file": _package_launch_files,
    "panel": _panels,
    "panel_argument": _panel_arguments,
    "param": _params,
    "place": _package_places,
    "request_text": _request_text,
    "service": _services,
    "service_type": _service_types,
    "throttle": _throttles,
    "topic": _topics,
    "topic_type": _topic_type,
}
"""Kind -> function that returns its values."""
