"""Manifests of packages: package.xml (REP 127, 140, 149) and rosbuild's manifest.xml and stack.xml."""

from __future__ import annotations

import os
from typing import Any
from xml.etree.ElementTree import Element, ParseError, tostring

from pyros1.drop_in.module_attributes import module_getattr
from rospkg.common import MANIFEST_FILE, PACKAGE_FILE, STACK_FILE

_DEPEND_TAGS = ("run_depend", "exec_depend", "build_depend", "build_export_depend", "buildtool_depend", "depend")
_REASON = "`pip install rospkg` provides it; pyros1 has parse_manifest_file"

__getattr__ = module_getattr(__name__, parse_manifest=_REASON, Platform=_REASON)


class InvalidManifest(Exception):
    """A manifest is invalid."""


class Depend:
    """A dependency on a package.

    Args:
        name: the package's name.
        type_: "package" or "stack".
    """

    __slots__ = ["name", "type"]

    def __init__(self, name: str, type_: str) -> None:
        if not name:
            raise ValueError(f"bad '{type_}' attribute")
        self.name = name
        self.type = type_

    def __eq__(self, obj: object) -> bool:
        return isinstance(obj, Depend) and (self.name, self.type) == (obj.name, obj.type)

    def __hash__(self) -> int:
        return hash((self.name, self.type))

    def __repr__(self) -> str:
        return self.name


class RosDep:
    """A dependency on a system package."""

    __slots__ = ["name"]

    def __init__(self, name: str) -> None:
        if not name:
            raise ValueError("bad 'name' attribute")
        self.name = name


class Export:
    """An element of ``<export>``.

    Args:
        tag: name of the element.
        attrs: its attributes.
        str: the text in it.
    """

    def __init__(self, tag: str, attrs: dict[str, str], str: str) -> None:
        self.tag = tag
        self.attrs = attrs
        self.str = str

    def get(self, attr: str) -> str | None:
        """Return an attribute; None if the element does not have it."""
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
        self.description = self.brief = self.author = self.license = self.license_url = self.url = ""
        self.version = self.status = self.notes = ""
        self.licenses: list[str] = []
        self.depends: list[Depend] = []
        self.rosdeps: list[RosDep] = []
        self.platforms: list[Any] = []
        self.exports: list[Export] = []
        self.unknown_tags: list[Any] = []
        self.type = type_
        self.filename = filename
        self.is_catkin = is_catkin

    def get_export(self, tag: str, attr: str, convert: bool = True) -> list[str]:
        """Return the values of an attribute in all exports with a tag.

        Args:
            tag: the exports' tag.
            attr: the attribute's name.
            convert: whether to replace ``${prefix}`` with the package's folder.

        Raises:
            ValueError: the folder is unknown, since ``filename`` is not set.
        """
        values = [value for export in self.exports if export.tag == tag and (value := export.get(attr)) is not None]
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
        manifest_name: manifest.xml or stack.xml; without such a file, the folder's package.xml is read.
        rospack: a RosPack. In a package.xml, dependencies that the RosPack contains count as ROS packages, all others
            as system packages. None to count all dependencies as ROS packages.

    Raises:
        InvalidManifest: the file is invalid.
        OSError: there is no such file.
    """
    from defusedxml.common import DefusedXmlException  # type: ignore[import-untyped]
    from defusedxml.ElementTree import fromstring  # type: ignore[import-untyped]

    path = os.path.join(dirpath, manifest_name)
    is_catkin = manifest_name == PACKAGE_FILE or not os.path.isfile(path)
    source = os.path.join(dirpath, PACKAGE_FILE) if is_catkin else path
    if not os.path.isfile(source):
        raise OSError(f"Invalid/non-existent manifest file: {path}")
    with open(source, "rb") as file:
        content = file.read()
    type_name = "stack" if manifest_name == STACK_FILE else "package"
    result = Manifest(type_name, os.path.join(dirpath, MANIFEST_FILE) if is_catkin else path, is_catkin)
    try:
        root: Element = fromstring(content)
        _set_fields(result, root)
        if is_catkin:
            names = dict.fromkeys(name for tag in _DEPEND_TAGS for name in _child_texts(root, tag))
            known_packages = names if rospack is None else set(rospack.list())
            result.depends = [Depend(name, "package") for name in names if name in known_packages]
            result.rosdeps = [RosDep(name) for name in names if name not in known_packages]
        elif root.tag != type_name:
            raise InvalidManifest(f"manifest [{path}] must have a single '{type_name}' element")
        else:
            result.depends = [Depend(element.get(type_name, ""), type_name) for element in root.findall("depend")]
            result.rosdeps = [RosDep(element.get("name", "")) for element in root.findall("rosdep")]
    except (ParseError, DefusedXmlException, ValueError, LookupError) as error:
        raise InvalidManifest(f"[{source}] invalid XML: {error}") from error
    except RecursionError as error:
        raise InvalidManifest(f"[{source}] invalid XML: elements are nested too deeply") from error
    return result


def _inner_xml(element: Element | None) -> str:
    if element is None:
        return ""
    return ((element.text or "") + "".join(tostring(child, "unicode") for child in element)).strip()


def _child_texts(root: Element, tag: str) -> list[str]:
    return [_inner_xml(element) for element in root.findall(tag)]


def _person(element: Element) -> str:
    mail = element.get("email")
    return _inner_xml(element) + (f" <{mail}>" if mail else "")


def _set_fields(manifest: Manifest, root: Element) -> None:
    description = root.find("description")
    manifest.description = _inner_xml(description)
    manifest.brief = "" if description is None else description.get("brief", "")
    people = [f"Maintainer: {_person(element)}" for element in root.findall("maintainer")]
    manifest.author = ", ".join([*people, *(_person(element) for element in root.findall("author"))])
    manifest.licenses = _child_texts(root, "license")
    manifest.license = ", ".join(manifest.licenses)
    manifest.url = next(iter(_child_texts(root, "url")), "")
    manifest.version = _inner_xml(root.find("version"))
    exports = [child for tag in root.findall("export") for child in tag]
    manifest.exports = [Export(child.tag, dict(child.attrib), _inner_xml(child)) for child in exports]
