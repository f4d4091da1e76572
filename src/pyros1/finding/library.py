"""Finds and parses definitions of messages and services by name, ``package/Type`` (G28).

The packages found by `packages` are searched first, then the definitions that come with pyros1. A package's folder can
contain the folders ``msg``, ``srv`` and ``action``; the messages of an action need no .msg files.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence

from pyros1.finding.packages import PackageIndex, share_folders
from pyros1.ground.errors import DefinitionError, PackageNotFoundError, UnknownTypeError
from pyros1.ground.suggest import did_you_mean
from pyros1.msgs.digest import Digests
from pyros1.msgs.spec import (
    MessageSpec,
    ServiceSpec,
    action_messages,
    is_type_name,
    parse_message,
    parse_service,
)

SHIPPED_DEFINITIONS = os.path.join(os.path.dirname(os.path.dirname(os.path.realpath(__file__))), "msgs", "definitions")
"""Folder of the definitions that come with pyros1."""

_MAX_HINTS = 3
_ACTION_PARTS = ("ActionGoal", "ActionResult", "ActionFeedback", "Action", "Goal", "Result", "Feedback")


class Library:
    """Parsed definitions of messages and services, each read once.

    Args:
        environ: environment variables; ``ROS_PACKAGE_PATH`` and ``CMAKE_PREFIX_PATH`` are used.
        installs: ``share`` folders of stock installations; None for the installations on this machine.
        shipped: folder of the definitions that come with pyros1.
    """

    def __init__(
        self,
        environ: Mapping[str, str],
        *,
        installs: Sequence[str | os.PathLike[str]] | None = None,
        shipped: str | os.PathLike[str] = SHIPPED_DEFINITIONS,
    ) -> None:
        roots = share_folders(environ) if installs is None else installs
        self._roots = [os.fspath(root) for root in (*roots, shipped)]
        self._packages = PackageIndex(environ, installs=installs)
        self._has_package_path = bool(environ.get("ROS_PACKAGE_PATH"))
        self._folders: dict[str, list[str]] = {}
        self._messages: dict[str, MessageSpec] = {}
        self._services: dict[str, ServiceSpec] = {}
        self.digests = Digests(self.message)

    def message(self, name: str) -> MessageSpec:
        """Return the parsed definition of a message type.

        Raises:
            UnknownTypeError: there is no such type.
            DefinitionError: the definition is invalid; the message names the file and the line.
        """
        spec = self.find_message(name)
        if spec is None:
            raise UnknownTypeError(self._unknown_type_message(name, "message"))
        return spec

    def find_message(self, name: str) -> MessageSpec | None:
        """Return the parsed definition of a message type, or None if there is no such type.

        This is used for names received from peers: unlike `message`, it does not search for similar names, which is
        slow.

        Raises:
            DefinitionError: the definition is invalid; the message names the file and the line.
        """
        spec = self._messages.get(name)
        if spec is None:
            spec = self._load_message(name)
            if spec is not None:
                self._messages[name] = spec
        return spec

    def service(self, name: str) -> ServiceSpec:
        """Return the parsed definition of a service type; raises the same errors as :meth:`message`."""
        spec = self._services.get(name)
        if spec is None:
            path = self._find_definition(name, "srv")
            if path is None:
                raise UnknownTypeError(self._unknown_type_message(name, "service"))
            spec = self._services[name] = parse_service(name, _read_definition(path), path)
        return spec

    def has_package(self, package: str) -> bool:
        """Return whether a package with that name exists and has definitions."""
        return any(map(_has_definitions, self.folders(package)))

    def messages(self, package: str) -> list[str]:
        """Return the short names of a package's messages, including its actions' messages, sorted."""
        names = set(self._definition_names(package, "msg"))
        for action in self._definition_names(package, "action"):
            names.update(action + part for part in _ACTION_PARTS)
        return sorted(names)

    def services(self, package: str) -> list[str]:
        """Return the short names of a package's services, sorted."""
        return sorted(set(self._definition_names(package, "srv")))

    def packages(self) -> list[str]:
        """Return the names of all packages that have definitions, sorted."""
        names: dict[str, None] = dict.fromkeys(self._packages.paths())
        for root in self._roots:
            names.update(
                dict.fromkeys(name for name in _list_folder(root) if _has_definitions(os.path.join(root, name)))
            )
        return sorted(name for name in names if self.has_package(name))

    def folders(self, package: str) -> list[str]:
        """Return the folders that may contain definitions of a package, in search order."""
        if "/" in package or not package.strip("."):
            return []  # such a name could lead outside the searched folders
        folders = self._folders.get(package)
        if folders is None:
            # Debian installs some message packages without a package.xml, so folders with the package's name are
            # accepted as well.
            folders = [folder for root in self._roots if os.path.isdir(folder := os.path.join(root, package))]
            try:
                found = self._packages.find_folder(package)
            except PackageNotFoundError:
                pass
            else:
                folders = [found, *(folder for folder in folders if folder != found)]
            self._folders[package] = folders
        return folders

    def _load_message(self, name: str) -> MessageSpec | None:
        path = self._find_definition(name, "msg")
        if path is not None:
            return parse_message(name, _read_definition(path), path)
        for part in _ACTION_PARTS:
            action = name.removesuffix(part)
            if action == name:
                continue
            path = self._find_definition(action, "action")
            if path is not None:
                return parse_message(name, action_messages(action, _read_definition(path), path)[name], path)
        return None

    def _find_definition(self, name: str, kind: str) -> str | None:
        if not is_type_name(name):
            return None
        package, _, short_name = name.partition("/")
        for folder in self.folders(package):
            path = os.path.join(folder, kind, f"{short_name}.{kind}")
            if os.path.isfile(path):
                return path
        return None

    def _definition_names(self, package: str, kind: str) -> Iterator[str]:
        for folder in self.folders(package):
            for name in _list_folder(os.path.join(folder, kind)):
                if name.endswith("." + kind):
                    yield name.removesuffix("." + kind)

    def missing_package_message(self, package: str) -> str:
        """Return the error message for a package that does not exist, with a suggestion."""
        hint = did_you_mean(package, self.packages())
        path_hint = "" if hint and self._has_package_path else "; is ROS_PACKAGE_PATH set?"
        return f"there is no package [{package}] with definitions{hint}{path_hint}"

    def _unknown_type_message(self, name: str, kind: str) -> str:
        list_names: Callable[[str], list[str]] = self.services if kind == "service" else self.messages
        if not is_type_name(name):
            full_names = [f"'{full}'" for full in self._full_names(name, list_names)]
            hint = f" (did you mean {' or '.join(full_names)}?)" if full_names else ""
            return f"[{name}] is not a {kind} type: it must have the form package/Type{hint}"
        package = name.partition("/")[0]
        short_names = list_names(package)
        if not self.has_package(package):
            return f"{kind} type [{name}] is unknown: {self.missing_package_message(package)}"
        hint = did_you_mean(name, (f"{package}/{short_name}" for short_name in short_names))
        available = f"; package [{package}] has {', '.join(short_names) or f'no {kind}s'}"
        return f"{kind} type [{name}] is unknown{hint or available}"

    def _full_names(self, name: str, list_names: Callable[[str], list[str]]) -> list[str]:
        """Return a few existing full names that may be meant by a name without a package, ``Type``, or by a ROS 2 name,
        ``package/msg/Type``.
        """
        package, short_name = name.partition("/")[0], name.rpartition("/")[2]
        if "/" in name:
            suggestion = f"{package}/{short_name}"
            return [suggestion] if suggestion != name and short_name in list_names(package) else []
        found = [f"{package}/{short_name}" for package in self.packages() if short_name in list_names(package)]
        return found[:_MAX_HINTS]


def _has_definitions(folder: str) -> bool:
    return any(os.path.isdir(os.path.join(folder, kind)) for kind in ("msg", "srv", "action"))


def _list_folder(folder: str) -> list[str]:
    """Return the names in a folder, except hidden ones; empty if the folder cannot be read."""
    try:
        return [name for name in os.listdir(folder) if name[0] != "."]
    except OSError:
        return []


def _read_definition(path: str) -> str:
    """Return the text of a definition file with ``\\n`` as line endings.

    Raises:
        DefinitionError: the file cannot be read.
    """
    try:
        with open(path, "rb") as file:
            data = file.read()
    except OSError as error:
        raise DefinitionError(f"cannot be read: {error.strerror}", path) from error
    try:
        text = data.decode()
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")
