"""The types of the installed ROS 2 packages, from the definitions in their ``share`` folders.

A package's folder is the one that belongs to its Python modules, which rclpy uses, or else one in AMENT_PREFIX_PATH.
Definitions are read on demand. Nothing is imported.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path

from pyros1.ground.errors import DefinitionError, Error, UnknownTypeError
from pyros1.ros2_types.definitions import MAX_TEXT_LENGTH, PARTS, parse_types
from pyros1.ros2_types.described import read_description
from pyros1.ros2_types.interfaces import action_types
from pyros1.ros2_types.model import MessageType, is_type_name
from pyros1.ros2_types.nesting import LayeredTypes
from pyros1.ros2_types.type_hash import service_hash, type_hash

MAX_PACKAGES = 10_000
"""Maximum number of package names, and of types, that are remembered, since other programs may name any."""
_COMPOSED = ("_SendGoal", "_GetResult", "_FeedbackMessage")


class RclpyPackages(Mapping[str, MessageType]):
    """The message types of all installed packages, and the parts of their services and actions.

    Args:
        prefixes: folders with a ``share`` folder, besides those that belong to Python modules; None for those in
            AMENT_PREFIX_PATH.
    """

    def __init__(self, prefixes: list[Path] | None = None) -> None:
        given = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
        self._prefixes = [Path(each) for each in given if each] if prefixes is None else prefixes
        self._shares: dict[str, Path | None] = {}
        self._types: dict[str, MessageType] = {}
        self._hashes: dict[str, str] = {}
        self._problems: dict[str, str] = {}

    def __getitem__(self, name: str) -> MessageType:
        if name not in self._types:
            self._read(name)
        return self._types[name]

    def __contains__(self, name: object) -> bool:
        if not isinstance(name, str):
            return False
        if name not in self._types:
            self._read(name)
        return name in self._types

    def __iter__(self) -> Iterator[str]:
        return iter([*self._types])

    def __len__(self) -> int:
        return len(self._types)

    def problem(self, name: str) -> str:
        """Return why a message, service or action type is not known; empty if it is."""
        if not is_type_name(name):
            return f"'{name:.200}' is not the name of a ROS 2 type"
        package, kind, short = name.split("/")
        if self._share(package) is None:
            return f"package {package} is not installed in this ROS 2 installation"
        if self._file(package, kind, _whole(kind, short)) is None:
            return f"package {package} of this ROS 2 installation has no {kind}/{_whole(kind, short)}"
        parts = PARTS[kind] if short == _whole(kind, short) else ()
        for part in parts:
            if name + part not in self:
                return self._problems.get(name, f"the definition of {name} cannot be read")
        return ""

    def hash_of(self, name: str) -> str:
        """Return the hash of a message or service type.

        Raises:
            UnknownTypeError: it is not installed.
        """
        if name not in self._hashes:
            if problem := self.problem(name):
                raise UnknownTypeError(problem)
            is_message = name in self
            self._hashes[name] = (type_hash if is_message else service_hash)(name, self)
        return self._hashes[name]

    def packages(self) -> list[str]:
        """Return the names of the packages with definitions in AMENT_PREFIX_PATH or next to rclpy, sorted."""
        return sorted({path.parts[-3] for kind in PARTS for path in self._definitions(kind)})

    def messages(self) -> list[str]:
        """Return the names of the message types defined in these packages, sorted."""
        return sorted({f"{path.parts[-3]}/msg/{path.stem}" for path in self._definitions("msg")})

    def _definitions(self, kind: str) -> Iterator[Path]:
        for prefix in [*self._prefixes, *_prefixes_of("rclpy")]:
            yield from (prefix / "share").glob(f"*/{kind}/*.{kind}")

    def _share(self, package: str) -> Path | None:
        """Return the ``share`` folder of a package; None if it is not installed."""
        if package not in self._shares:
            if len(self._shares) >= MAX_PACKAGES:
                self._shares.clear()
            folders = (prefix / "share" / package for prefix in [*_prefixes_of(package), *self._prefixes])
            self._shares[package] = next(filter(Path.is_dir, folders), None)
        return self._shares[package]

    def _file(self, package: str, kind: str, short: str) -> Path | None:
        share = self._share(package)
        files = [] if share is None else [share / kind / f"{short}.{end}" for end in (kind, "json")]
        return next(filter(Path.is_file, files), None)

    def _read(self, name: str) -> None:
        """Read the definition of a type, or of the service or action that it is part of, if there is one."""
        if not is_type_name(name) or name in self._problems:
            return
        package, kind, short = name.split("/")
        whole = f"{package}/{kind}/{_whole(kind, short)}"
        path = self._file(package, kind, _whole(kind, short))
        if path is None or whole in self._problems:
            return
        try:
            text = _read_text(path)
            types = parse_types(whole, text) if path.suffix != ".json" else read_description(text)
            self._types.update((each, type_) for each, type_ in types.items() if each not in self._types)
            if kind == "action":
                self._types.update(action_types(whole, LayeredTypes(types, self)))
        except (Error, OSError, ValueError) as error:
            if len(self._problems) >= MAX_PACKAGES:
                self._problems.clear()
            self._problems[whole] = f"the definition of {whole} cannot be read: {error}"


def _read_text(path: Path) -> str:
    with path.open(encoding="utf-8") as file:
        text = file.read(MAX_TEXT_LENGTH + 1)
    if len(text) > MAX_TEXT_LENGTH:
        raise DefinitionError(f"longer than {MAX_TEXT_LENGTH} characters", str(path))
    return text


def _prefixes_of(package: str) -> Iterator[Path]:
    """Yield the folders above a Python package that have a ``share`` folder, nearest first."""
    try:
        spec = find_spec(package)
    except (ImportError, ValueError):  # the name is not a package's
        return
    for location in (spec.submodule_search_locations or ()) if spec is not None else ():
        for parent in Path(location).parents:
            if (parent / "share").is_dir():
                yield parent


def _whole(kind: str, short: str) -> str:
    """Return the name of the service or action that a type is part of, or the type's own name."""
    if kind == "msg":
        return short
    for part in (*PARTS["srv"], *PARTS["action"], "_Event"):
        short = short.removesuffix(part)
    for part in _COMPOSED if kind == "action" else ():
        short = short.removesuffix(part)
    return short
