"""Reads the manifests of packages: package.xml in formats 1 to 3 (REP 127, 140, 149) and rosbuild's manifest.xml."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from xml.etree.ElementTree import Element, ParseError

from pyros1.ground.errors import Error

RUN_TAGS = ("run_depend", "exec_depend", "depend")
"""Tags of a catkin package's run-time dependencies, in rospack's order."""

_DEPENDENCY_TAGS = frozenset(
    [
        *RUN_TAGS,
        "build_depend",
        "build_export_depend",
        "buildtool_depend",
        "buildtool_export_depend",
        "test_depend",
        "doc_depend",
    ]
)


class ManifestError(Error):
    """A manifest cannot be read or is invalid; the message names the file or the package."""


@dataclass(frozen=True)
class Manifest:
    """A package's manifest.

    Attributes:
        name: name of the package.
        path: path of the file.
        is_catkin: whether the file is a package.xml rather than a manifest.xml.
        depends: (tag, package) of each dependency, as written.
        exports: (tag, attributes) of each export.
        system_keys: rosdep keys of system packages, from a manifest.xml's ``rosdep`` tags.
        version: the version as written; empty if there is none.
        is_metapackage: whether it is a metapackage.
    """

    name: str
    path: Path
    is_catkin: bool
    version: str = ""
    depends: list[tuple[str, str]] = field(default_factory=list)
    exports: list[tuple[str, dict[str, str]]] = field(default_factory=list)
    system_keys: list[str] = field(default_factory=list)
    is_metapackage: bool = False

    def run_dependencies(self) -> list[str]:
        """Return the names of the run-time dependencies, or of all dependencies for a rosbuild package, without
        duplicates.
        """
        if not self.is_catkin:
            return list(dict.fromkeys(name for _, name in self.depends))
        return list(dict.fromkeys(name for run_tag in RUN_TAGS for tag, name in self.depends if tag == run_tag))

    def exported_values(self, language: str, attribute: str) -> list[str]:
        """Return the values of ``attribute`` in exports with the tag ``language``; ``${prefix}`` is replaced."""
        prefix = str(self.path.parent)
        values = [values[attribute] for tag, values in self.exports if tag == language and attribute in values]
        return [value.replace("${prefix}", prefix) for value in values]


def read_manifest(path: Path, name: str = "") -> Manifest:
    """Read a manifest.

    Args:
        path: path of package.xml, manifest.xml or stack.xml.
        name: the name to use if the file contains none; empty to use the folder's name.

    Raises:
        ManifestError: the file cannot be read, or is not a manifest.
    """
    from defusedxml.common import DefusedXmlException  # type: ignore[import-untyped] # noqa: PLC0415 - most commands only need names
    from defusedxml.ElementTree import fromstring  # type: ignore[import-untyped] # noqa: PLC0415

    if path.exists() and not path.is_file():  # reading a device might never end, and a pipe might block
        raise ManifestError(f"cannot read {path}: it is not a regular file")
    try:
        root = fromstring(path.read_bytes())
    except OSError as error:
        raise ManifestError(f"cannot read {path}: {error.strerror}") from error
    except (ParseError, DefusedXmlException, ValueError, LookupError) as error:  # LookupError: an unknown encoding
        raise ManifestError(f"{path} is not valid XML: {error}") from error
    if root.tag not in ("package", "stack"):
        raise ManifestError(f"{path}: the root element is <{root.tag}>, not <package>")
    name = _element_text(root.find("name")) or name or path.parent.name
    is_catkin = path.name == "package.xml"
    exports = [(child.tag, dict(child.attrib)) for tag in root.findall("export") for child in tag]
    return Manifest(
        name,
        path,
        is_catkin,
        version=_element_text(root.find("version")),
        depends=_read_dependencies(root, is_catkin),
        exports=exports,
        system_keys=[child.attrib["name"] for child in root.findall("rosdep") if "name" in child.attrib],
        is_metapackage=any(tag == "metapackage" for tag, _ in exports),
    )


def _read_dependencies(root: Element, is_catkin: bool) -> list[tuple[str, str]]:
    if is_catkin:
        return [
            (child.tag, _element_text(child))
            for child in root
            if child.tag in _DEPENDENCY_TAGS and _element_text(child)
        ]
    names = [(child.get("package") or child.get("stack") or "") for child in root.findall("depend")]
    return [("depend", name) for name in names if name]


def _element_text(element: Element | None) -> str:
    return (element.text or "").strip() if element is not None else ""
