"""Manifests of packages (REP 127, 140, 149, and https://wiki.ros.org/Manifest)."""

from __future__ import annotations

import os
from typing import Any
from xml.etree.ElementTree import Element, ParseError, tostring

from pyros1.drop_in.missing import missing
from rospkg.common import MANIFEST_FILE, PACKAGE_FILE, STACK_FILE

_RUN_TAGS = ("run_depend", "exec_depend", "build_depend", "build_export_depend", "buildtool_depend", "depend")
_KNOWN = {
    *("author", "brief", "depend", "description", "export", "license", "logo", "name", "notes", "platform", "review"),
    *("rosdep", "status", "url", "version", "versioncontrol"),
}

__getattr__ = missing(__name__)


class InvalidManifest(Exception):
    """A manifest is wrong."""


class Depend:
    """A package that a package needs.

    Args:
        name: its name.
        type_: "package" or "stack".
    """

    __slots__ = ["name", "type"]

    def __init__(self, name: str, type_: str) -> None:
        self.name = name
        self.type = type_

    def __eq__(self, obj: object) -> bool:
        return isinstance(obj, Depend) and (self.name, self.type) == (obj.name, obj.type)

    def __hash__(self) -> int:
        return hash((self.name, self.type))

    def __repr__(self) -> str:
        return self.name

    __str__ = __repr__


class RosDep:
    """A system package that a package needs."""

    __slots__ = ["name"]

    def __init__(self, name: str) -> None:
        self.name = name


class Platform:
    """A system on which a package works."""

    __slots__ = ["os", "version", "notes"]  # noqa: RUF023

    def __init__(self, os_: str, version: str, notes: str | None = None) -> None:
        if not os_ or not version:
            raise ValueError("os and version must be given")
        self.os = os_
        self.version = version
        self.notes = notes

    def __eq__(self, obj: object) -> bool:
        return isinstance(obj, Platform) and all(getattr(self, n) == getattr(obj, n) for n in self.__slots__)

    def __hash__(self) -> int:
        return hash((self.os, self.version, self.notes))

    def __repr__(self) -> str:
        return f"{self.os} {self.version}"

    __str__ = __repr__


class Export:
    """What a package exports.

    Args:
        tag: kind of export.
        attrs: attribute -> value.
        str: text of the element.
    """

    def __init__(self, tag: str, attrs: dict[str, str], str: str) -> None:
        self.tag = tag
        self.attrs = attrs
        self.str = str

    def get(self, attr: str) -> str | None:
        """Return an attribute; None if it is not there."""
        return self.attrs.get(attr)


class Manifest:
    """A package's manifest.

    Args:
        type_: "package" or "stack".
        filename: path of the file.
        is_catkin: whether it is a package.xml.
    """

    __slots__ = [
        *("description", "brief", "author", "license", "licenses", "license_url", "url", "depends", "rosdeps"),
        *("platforms", "exports", "version", "status", "notes", "unknown_tags", "type", "filename", "is_catkin"),
    ]

    def __init__(self, type_: str = "package", filename: str | None = None, is_catkin: bool = False) -> None:
        self.description = self.brief = self.author = self.license = self.license_url = ""
        self.url: str | None = ""
        self.version: str | None = ""
        self.status = self.notes = ""
        self.licenses: list[str] = []
        self.depends: list[Depend] = []
        self.rosdeps: list[RosDep] = []
        self.platforms: list[Platform] = []
        self.exports: list[Export] = []
        self.unknown_tags: list[Any] = []
        self.type = type_
        self.filename = filename
        self.is_catkin = is_catkin

    def get_export(self, tag: str, attr: str, convert: bool = True) -> list[str]:
        """Return an attribute of all exports of a kind.

        Args:
            tag: the kind.
            attr: the attribute.
            convert: whether ``${prefix}`` becomes the package's folder.
        """
        values = [value for each in self.exports if each.tag == tag and (value := each.get(attr)) is not None]
        if not convert or self.filename is None:
            return values
        folder = os.path.dirname(self.filename)
        return [value.replace("${prefix}", folder) for value in values]


def parse_manifest_file(dirpath: str, manifest_name: str, rospack: Any = None) -> Manifest:
    """Read a manifest.

    Args:
        dirpath: the package's folder.
        manifest_name: manifest.xml or stack.xml; if there is none, the package.xml there is read.
        rospack: tells which dependencies of a package.xml are ROS packages; the others are system packages. None:
            all are ROS packages.

    Raises:
        InvalidManifest: the file is wrong.
        OSError: there is no such file.
    """
    path = os.path.join(dirpath, manifest_name)
    modern = os.path.join(dirpath, PACKAGE_FILE)
    source = path if os.path.isfile(path) else modern
    if not os.path.isfile(source):
        raise OSError(f"Invalid/non-existent manifest file: {os.path.join(dirpath, manifest_name)}")
    with open(source, "rb") as file:
        root = _root(file.read(), source)
    if source == modern:
        return _modern(root, os.path.join(dirpath, MANIFEST_FILE), rospack)
    return _old(root, manifest_name, path)


def parse_manifest(manifest_name: str, string: str | bytes, filename: str = "string") -> Manifest:
    """Return the manifest in a text; arguments and errors as for :func:`parse_manifest_file`."""
    return _old(_root(string.encode() if isinstance(string, str) else string, filename), manifest_name, filename)


def _root(text: bytes, where: str) -> Element:
    from defusedxml.common import DefusedXmlException  # type: ignore[import-untyped]
    from defusedxml.ElementTree import fromstring  # type: ignore[import-untyped]

    try:
        root: Element = fromstring(text)
    except (ParseError, DefusedXmlException, ValueError) as error:
        raise InvalidManifest(f"[{where}] invalid XML: {error}") from error
    return root


def _inner(element: Element | None) -> str:
    if element is None:
        return ""
    return ((element.text or "") + "".join(tostring(child, "unicode") for child in element)).strip()


def _texts(root: Element, tag: str) -> list[str]:
    return [_inner(each) for each in root.findall(tag)]


def _exports(root: Element) -> list[Export]:
    return [Export(c.tag, dict(c.attrib), _inner(c)) for tag in root.findall("export") for c in tag]


def _person(element: Element) -> str:
    mail = element.get("email")
    return _inner(element) + (f" <{mail}>" if mail else "")


def _modern(root: Element, filename: str, rospack: Any) -> Manifest:
    result = Manifest(filename=filename, is_catkin=True)
    result.description = _inner(root.find("description"))
    people = [_person(each) for each in root.findall("maintainer")]
    authors = [_person(each) for each in root.findall("author")]
    result.author = ", ".join([f"Maintainer: {', '.join(people)}", *authors] if people else authors)
    result.licenses = _texts(root, "license")
    result.license = ", ".join(result.licenses)
    result.url = next((_inner(e) for e in root.findall("url") if e.get("type", "website") == "website"), "")
    result.version = _inner(root.find("version"))
    result.exports = _exports(root)
    names = dict.fromkeys(name for tag in _RUN_TAGS for name in _texts(root, tag))
    known = names if rospack is None else set(rospack.list())
    result.depends = [Depend(name, "package") for name in names if name in known]
    result.rosdeps = [RosDep(name) for name in names if name not in known]
    return result


def _old(root: Element, manifest_name: str, filename: str) -> Manifest:
    kind = "stack" if manifest_name == STACK_FILE else "package"
    if root.tag != kind:
        raise InvalidManifest(f"Invalid manifest file: must have only one '{kind}' element")
    if len(root.findall("license")) != 1:
        raise InvalidManifest("Invalid manifest file: must have only one 'license' element")
    result = Manifest(kind, filename)
    about = root.find("description")
    result.description = _inner(about)
    result.brief = about.get("brief", "") if about is not None else ""
    result.author = ", ".join(_texts(root, "author"))
    licence = root.find("license")
    result.license = _inner(licence)
    result.license_url = licence.get("url", "") if licence is not None else ""
    review = root.find("review")
    result.status = "unreviewed" if review is None else review.get("status", "")
    result.notes = "" if review is None else review.get("notes", "")
    result.url = next(iter(_texts(root, "url")), None)
    result.version = next(iter(_texts(root, "version")), None)
    result.depends = [Depend(each.get(kind, ""), kind) for each in root.findall("depend")]
    result.rosdeps = [RosDep(each.get("name", "")) for each in root.findall("rosdep")]
    result.platforms = [
        Platform(each.get("os", ""), each.get("version", ""), each.get("notes")) for each in root.findall("platform")
    ]
    result.exports = _exports(root)
    result.unknown_tags = [each for each in root if each.tag not in _KNOWN]
    return result
