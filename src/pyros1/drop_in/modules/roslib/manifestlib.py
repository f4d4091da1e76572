"""The parts of a manifest.xml, from before rospkg."""

from __future__ import annotations

import os
from typing import Any
from xml.parsers.expat import ExpatError
from xml.sax.saxutils import quoteattr

import rospkg.manifest
from rospkg._dom import children, only, text

from pyros1.drop_in.missing import missing
from roslib.exceptions import ROSLibException

__getattr__ = missing(__name__)


class ManifestException(ROSLibException):
    """A manifest is wrong."""


def _xml(tag: str, end: str = " />", **attributes: str | None) -> str:
    return f"<{tag}" + "".join(f" {key}={quoteattr(str(value))}" for key, value in attributes.items()) + end


class Platform(rospkg.manifest.Platform):
    """A system on which a package works."""

    def xml(self) -> str:
        """Return the element."""
        notes = {} if self.notes is None else {"notes": self.notes}
        return _xml("platform", "/>", os=self.os, version=self.version, **notes)


class Depend:
    """A package that a package needs; raises ValueError for an empty name."""

    __slots__ = ["package"]

    def __init__(self, package: str) -> None:
        if not package:
            raise ValueError("bad 'package' attribute")
        self.package = package

    def __eq__(self, obj: object) -> bool:
        return isinstance(obj, Depend) and self.package == obj.package

    def __hash__(self) -> int:
        return hash(self.package)

    def __repr__(self) -> str:
        return self.package

    def xml(self) -> str:
        """Return the element."""
        return _xml("depend", package=self.package)


class ROSDep(rospkg.manifest.RosDep):
    """A system package that a package needs; raises ValueError for an empty name."""

    def xml(self) -> str:
        """Return the element."""
        return _xml("rosdep", name=self.name)


class VersionControl:
    """Where a package's source is kept; raises ValueError for an empty kind."""

    __slots__ = ["type", "url"]

    def __init__(self, type_: str, url: str) -> None:
        if not type_ or not isinstance(type_, str):
            raise ValueError("bad 'type' attribute")
        self.type = type_
        self.url = url

    def xml(self) -> str:
        """Return the element."""
        return _xml("versioncontrol", type=self.type, **({"url": self.url} if self.url else {}))


class Export(rospkg.manifest.Export):
    """What a package exports."""

    def xml(self) -> str:
        """Return the element."""
        start = _xml(self.tag, "", **self.attrs)
        return f"{start}>{self.str}</{self.tag}>" if self.str else f"{start} />"


def parse(m: Any, string: str | bytes, filename: str = "string") -> Any:
    """Fill a `roslib.manifest.Manifest` from a text, and return it; raises ManifestException."""
    from defusedxml.common import DefusedXmlException  # type: ignore[import-untyped]
    from defusedxml.minidom import parseString  # type: ignore[import-untyped]

    try:
        root = parseString(string).documentElement
    except (ExpatError, DefusedXmlException, ValueError, TypeError, LookupError) as error:
        raise ManifestException(f"invalid XML: {error}") from error
    if root.tagName != "package":
        raise ManifestException("manifest must have a single 'package' element")
    if children(root, "version"):
        raise ManifestException("<version> tag is not valid in a package manifest.xml file")
    try:
        found = rospkg.manifest.parse_manifest(rospkg.MANIFEST_FILE, string, "")
    except rospkg.InvalidManifest as error:
        raise ManifestException(str(error).replace("Invalid manifest file []:", "Invalid manifest file:")) from None
    try:
        logo = only(root, "logo")
    except ValueError as error:
        raise ManifestException(f"Invalid manifest file: {error}") from None
    for name in ("brief", "description", "license", "license_url", "url", "status", "notes", "unknown_tags"):
        setattr(m, name, getattr(found, name))
    m.author = found.author or ""
    m.version = None
    m.logo = None if logo is None else text(logo).strip()
    controls = [(each.getAttribute("type"), each.getAttribute("url")) for each in children(root, "versioncontrol")]
    m.versioncontrol = VersionControl(*controls[0]) if controls else None
    m.depends = [Depend(each.name) for each in found.depends]
    m.rosdeps = [ROSDep(each.name) for each in found.rosdeps]
    m.platforms = [Platform(each.os, each.version, each.notes) for each in found.platforms]
    m.exports = [Export(each.tag, each.attrs, each.str) for each in found.exports]
    return m


def parse_file(m: Any, file: str) -> Any:
    """Fill a `roslib.manifest.Manifest` from a file, and return it.

    Raises:
        ValueError: there is no such file.
        ManifestException: it is wrong.
    """
    if not file:
        raise ValueError("Missing manifest file argument")
    try:
        with open(file, "rb") as content:
            text = content.read()
    except OSError:
        raise ValueError(f"Invalid/non-existent manifest file: {file}") from None
    try:
        return parse(m, text, file)
    except ManifestException as error:
        raise ManifestException(f"Invalid manifest file [{os.path.abspath(file)}]: {error}") from None
