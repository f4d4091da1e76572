"""Definitions by name: where the text of ``package/Type`` is found on this machine (G28).

In this order: packages where `packages` looks for them, the definitions that come with pyros1. A package's
folder has ``msg``, ``srv`` and ``action``; the messages of an action need no .msg files.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from pyros1.errors import DefinitionError, PackageNotFoundError, UnknownTypeError
from pyros1.msgs.digest import Digests
from pyros1.msgs.packages import PackageIndex, share_folders
from pyros1.msgs.spec import (
    MessageSpec,
    ServiceSpec,
    action_messages,
    is_type_name,
    parse_message,
    parse_service,
)

SHIPPED = Path(__file__).resolve().parent / "definitions"
"""Folder of the definitions that are part of pyros1."""

_ACTION_PARTS = ("ActionGoal", "ActionResult", "ActionFeedback", "Action", "Goal", "Result", "Feedback")


class Library:
    """Finds and parses definitions; remembers what it parsed.

    Args:
        environ: environment variables, for ``ROS_PACKAGE_PATH``.
        installs: ``share`` folders of stock installations; None means those of this machine.
        shipped: folder of pyros1's own definitions.
    """

    def __init__(
        self, environ: Mapping[str, str], *, installs: Sequence[Path] | None = None, shipped: Path = SHIPPED
    ) -> None:
        self._installs = list(share_folders(environ) if installs is None else installs)
        self._shipped = shipped
        self._packages = PackageIndex(environ, installs=installs)
        self._folders: dict[str, list[Path]] = {}
        self._messages: dict[str, MessageSpec] = {}
        self._services: dict[str, ServiceSpec] = {}
        self.digests = Digests(self.message)

    def message(self, name: str) -> MessageSpec:
        """Return the parsed definition of a message type.

        Raises:
            UnknownTypeError: there is none.
            DefinitionError: it is wrong; the text names file and line.
        """
        spec = self._messages.get(name)
        if spec is None:
            spec = self._messages[name] = self._load_message(name)
        return spec

    def service(self, name: str) -> ServiceSpec:
        """Return the parsed definition of a service type; raises as :meth:`message`."""
        spec = self._services.get(name)
        if spec is None:
            path = self._find(name, "srv")
            if path is None:
                raise UnknownTypeError(self._not_found(name, "service"))
            spec = self._services[name] = parse_service(name, _read(path), str(path))
        return spec

    def has_package(self, package: str) -> bool:
        """Tell whether there are definitions of that package."""
        return any((folder / kind).is_dir() for folder in self.folders(package) for kind in ("msg", "srv", "action"))

    def messages(self, package: str) -> list[str]:
        """Return the short names of a package's messages, sorted, those of its actions included."""
        names = {path.stem for path in self._files(package, "msg")}
        for path in self._files(package, "action"):
            names.update(path.stem + part for part in _ACTION_PARTS)
        return sorted(names)

    def services(self, package: str) -> list[str]:
        """Return the short names of a package's services, sorted."""
        return sorted({path.stem for path in self._files(package, "srv")})

    def packages(self) -> list[str]:
        """Return the names of all packages that have definitions, sorted."""
        found: dict[str, None] = dict.fromkeys(self._packages.paths())
        for root in (*self._installs, self._shipped):
            for kind in ("msg", "srv", "action"):
                found.update(dict.fromkeys(path.parent.name for path in root.glob(f"*/{kind}")))
        return sorted(name for name in found if self.has_package(name))

    def folders(self, package: str) -> list[Path]:
        """Return the folders that may hold definitions of a package, the first to be asked first."""
        folders = self._folders.get(package)
        if folders is None:
            # Debian installs some message packages without a package.xml, so these folders count by their name.
            folders = [root / package for root in (*self._installs, self._shipped) if (root / package).is_dir()]
            try:
                found = self._packages.find(package)
            except PackageNotFoundError:
                pass
            else:
                folders = [found, *(folder for folder in folders if folder != found)]
            self._folders[package] = folders
        return folders

    def _load_message(self, name: str) -> MessageSpec:
        path = self._find(name, "msg")
        if path is not None:
            return parse_message(name, _read(path), str(path))
        for part in _ACTION_PARTS:
            action = name.removesuffix(part)
            if action == name:
                continue
            path = self._find(action, "action")
            if path is not None:
                return parse_message(name, action_messages(action, _read(path), str(path))[name], str(path))
        raise UnknownTypeError(self._not_found(name, "message"))

    def _find(self, name: str, kind: str) -> Path | None:
        if not is_type_name(name):
            return None
        package, _, short = name.partition("/")
        for folder in self.folders(package):
            path = folder / kind / f"{short}.{kind}"
            if path.is_file():
                return path
        return None

    def _files(self, package: str, kind: str) -> Iterator[Path]:
        for folder in self.folders(package):
            yield from (folder / kind).glob(f"*.{kind}")

    def _not_found(self, name: str, what: str) -> str:
        if not is_type_name(name):
            return f"[{name}] is not a {what} type: it must have the form package/Type"
        package = name.partition("/")[0]
        names: Callable[[str], list[str]] = self.services if what == "service" else self.messages
        known = names(package)
        if not known:
            return f"{what} type [{name}] is unknown: no package [{package}] with definitions; is ROS_PACKAGE_PATH set?"
        from pyros1.suggest import did_you_mean  # noqa: PLC0415 - only what fails needs it

        hint = did_you_mean(name, (f"{package}/{short}" for short in known))
        return f"{what} type [{name}] is unknown{hint or f'; package [{package}] has ' + ', '.join(known)}"


def _read(path: Path) -> str:
    """Return the text of a definition file, line ends as ``\\n``."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise DefinitionError(f"cannot be read: {error.strerror}", str(path)) from error
    try:
        text = data.decode()
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    return text.replace("\r\n", "\n").replace("\r", "\n")
