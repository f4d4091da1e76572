"""Manifests of packages (REP 127, 140, 149, and https://wiki.ros.org/Manifest)."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from xml.etree.ElementTree import Element, ParseError, tostring
from xml.parsers.expat import ExpatError

from pyros1.drop_in.missing import missing
from rospkg._dom import children, only, text
from rospkg.common import MANIFEST_FILE, PACKAGE_FILE, STACK_FILE

_RUN_TAGS = ("run_depend", "exec_depend", "build_depend", "build_export_depend", "buildtool_depend", "depend")
_KNOWN = {
    *("author", "brief", "depend", "description", "export", "license", "logo", "notes", "platform", "review"),
    *("rosdep", "status", "url", "version", "versioncontrol"),
}

__getattr__ = missing(__name__)


class InvalidManifest(Exception):
    """A manifest is wrong."""


def _filled(value: str, attribute: str) -> str:
    if not value:
        raise ValueError(f"bad '{attribute}' attribute")
    return value


class Depend:
    """A package that a package needs.

    Args:
        name: its name.
        type_: "package" or "stack".
    """

    __slots__ = ["name", "type"]

    def __init__(self, name: str, type_: str) -> None:
        if not type_:
            raise ValueError("type_ must be specified")
        self.name = _filled(name, type_)
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
        self.name = _filled(name, "name")


class Platform:
    """A system on which a package works."""

    __slots__ = ["os", "version", "notes"]  # noqa: RUF023

    def __init__(self, os_: str, version: str, notes: str | None = None) -> None:
        self.os = _filled(os_, "os")
        self.version = _filled(version, "version")
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
        self.brief = self.license = self.license_url = ""
        self.description: str | None = ""
        self.author: str | None = ""
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

        Raises:
            ValueError: the folder is not known.
        """
        values = [value for each in self.exports if each.tag == tag and (value := each.get(attr)) is not None]
        if not convert:
            return values
        if not self.filename:
            raise ValueError("cannot convert export values when filename for Manifest is not set")
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
        content = file.read()
    if source == modern:
        filename = os.path.join(dirpath, MANIFEST_FILE)
        with _not_too_deep(f"[{filename}]"):
            return _modern(content, filename, rospack)
    return parse_manifest(manifest_name, content, path)


def parse_manifest(manifest_name: str, string: str | bytes, filename: str = "string") -> Manifest:
    """Return the manifest in a text; arguments and errors as for :func:`parse_manifest_file`."""
    from defusedxml.minidom import parseString  # type: ignore[import-untyped]

    with _complaints(f"[{filename}]"):
        document = parseString(string)
    with _not_too_deep(f"[{filename}]"):
        return _old(document.documentElement, "stack" if manifest_name == STACK_FILE else "package", filename)


@contextmanager
def _complaints(where: str) -> Iterator[None]:
    """Let errors of an XML parser be InvalidManifest."""
    from defusedxml.common import DefusedXmlException  # type: ignore[import-untyped]

    try:
        yield
    except (ParseError, ExpatError, DefusedXmlException, ValueError, TypeError, LookupError) as error:
        raise InvalidManifest(f"{where} invalid XML: {error}") from error


@contextmanager
def _not_too_deep(where: str) -> Iterator[None]:
    try:
        yield
    except RecursionError as error:
        raise InvalidManifest(f"{where} invalid XML: elements are nested too deeply") from error


# package.xml ----------------------------------------------------------------------------------------------------------


def _inner(element: Element | None) -> str:
    if element is None:
        return ""
    return ((element.text or "") + "".join(tostring(child, "unicode") for child in element)).strip()


def _texts(root: Element, tag: str) -> list[str]:
    return [_inner(each) for each in root.findall(tag)]


def _person(element: Element) -> str:
    mail = element.get("email")
    return _inner(element) + (f" <{mail}>" if mail else "")


def _modern(content: bytes, filename: str, rospack: Any) -> Manifest:
    from defusedxml.ElementTree import fromstring  # type: ignore[import-untyped]

    with _complaints(f"[{filename}]"):
        root: Element = fromstring(content)
    result = Manifest(filename=filename, is_catkin=True)
    result.description = _inner(root.find("description"))
    people = [f"Maintainer: {_person(each)}" for each in root.findall("maintainer")]
    result.author = ", ".join([*people, *(_person(each) for each in root.findall("author"))])
    result.licenses = _texts(root, "license")
    result.license = ", ".join(result.licenses)
    result.url = next(iter(_texts(root, "url")), "")
    result.version = _inner(root.find("version"))
    result.exports = [
        Export(child.tag, dict(child.attrib), _inner(child)) for tag in root.findall("export") for child in tag
    ]
    names = dict.fromkeys(name for tag in _RUN_TAGS for name in _texts(root, tag))
    known = names if rospack is None else set(rospack.list())
    result.depends = [Depend(name, "package") for name in names if name in known]
    result.rosdeps = [RosDep(name) for name in names if name not in known]
    return result


# manifest.xml and stack.xml -------------------------------------------------------------------------------------------


def _old(root: Any, kind: str, filename: str) -> Manifest:
    """Return the manifest of a DOM element: programs find such elements in ``unknown_tags``, too."""
    if root.tagName != kind:
        raise InvalidManifest(f"manifest [{filename}] must have a single '{kind}' element")
    where = f"Invalid manifest file [{filename}]:"
    result = Manifest(kind, filename)
    if len(children(root, "license")) > 1:
        raise InvalidManifest("Invalid manifest file: must have only one 'license' element")
    try:
        about, licence, url, version = (only(root, tag) for tag in ("description", "license", "url", "version"))
    except ValueError as error:
        raise InvalidManifest(f"{where} {error}") from None
    result = Manifest(kind, filename)
    try:
        about, licence, url, version = (only(root, tag) for tag in ("description", "license", "url", "version"))
    except ValueError as error:
        raise InvalidManifest(f"Invalid manifest file [{filename}]: {error}") from None
    result.description = None if about is None else "".join(child.toxml() for child in about.childNodes)
    result.brief = "" if about is None else about.getAttribute("brief")
    authors = [text(each).strip() for each in children(root, "author")]
    result.author = ", ".join(authors) if authors else None
    if licence is not None:
        result.license, result.license_url = text(licence).strip(), licence.getAttribute("url")
    result.status = "unreviewed"
    for review in children(root, "review")[:1]:
        result.status, result.notes = review.getAttribute("status"), review.getAttribute("notes")
    result.url = None if url is None else text(url).strip()
    result.version = None if version is None else text(version).strip()
    for each in children(root, "depend"):
        if not each.hasAttribute(kind):
            raise InvalidManifest(f"{where} depends is missing '{kind}' attribute")
        result.depends.append(Depend(each.getAttribute(kind), kind))
    for each in children(root, "rosdep"):
        if not each.hasAttribute("name"):
            raise InvalidManifest(f"invalid rosdep tag in [{filename}]")
        result.rosdeps.append(RosDep(each.getAttribute("name")))
    result.platforms = [_platform(each) for each in children(root, "platform")]
    result.exports = [
        Export(child.tagName, dict(child.attributes.items()), text(child))
        for tag in children(root, "export")
        for child in children(tag)
    ]
    result.unknown_tags = [each for each in children(root) if each.tagName not in _KNOWN]
    return result


def _platform(element: Any) -> Platform:
    for needed in ("os", "version"):
        if not element.hasAttribute(needed):
            raise InvalidManifest(f"<platform> tag is missing required ''{needed}'' attribute")
    return Platform(*(element.getAttribute(name) for name in ("os", "version", "notes")))
