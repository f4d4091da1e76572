"""Manifests of packages, from before rospkg."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from rospkg.common import MANIFEST_FILE

from pyros1.drop_in.missing import missing
from roslib import manifestlib
from roslib.manifestlib import Depend, Export, ManifestException, ROSDep, VersionControl
from roslib.packages import InvalidROSPkgException, get_pkg_dir

__getattr__ = missing(__name__)


class Manifest:
    """What a package's manifest.xml says.

    Attributes:
        description, author, license, url, logo, version, brief, license_url, status, notes: texts; some are None if
            there are none.
        depends, rosdeps, exports, platforms: lists of the classes of `roslib.manifestlib`. versioncontrol: one.
        unknown_tags: the elements of other names.
    """

    __slots__ = [
        *("description", "brief", "author", "license", "license_url", "url", "depends", "rosdeps", "platforms"),
        *("exports", "version", "versioncontrol", "status", "notes", "logo", "unknown_tags"),
    ]

    def __init__(self) -> None:
        self.description: str | None = ""
        self.brief = self.author = self.license = self.license_url = self.status = self.notes = ""
        self.url: str | None = ""
        self.version: str | None = ""
        self.logo: str | None = ""
        self.versioncontrol: VersionControl | None = None
        self.depends: list[Depend] = []
        self.rosdeps: list[ROSDep] = []
        self.exports: list[Export] = []
        self.platforms: list[manifestlib.Platform] = []
        self.unknown_tags: list[Any] = []

    def get_export(self, tag: str, attr: str) -> list[str]:
        """Return an attribute of all exports of a kind."""
        return [value for each in self.exports if each.tag == tag and (value := each.get(attr)) is not None]

    def xml(self) -> str:
        """Return the manifest as XML."""
        brief = f' brief="{self.brief}"' if self.brief else ""
        url = f' url="{self.license_url}"' if self.license_url else ""
        lines = [
            "<package>",
            f"  <description{brief}>{self.description}</description>",
            f"  <author>{self.author}</author>",
            f"  <license{url}>{self.license}</license>",
        ]
        if self.status:
            lines.append(f'  <review status="{self.status}" notes="{self.notes}" />')
        lines += [f"  <{tag}>{value}</{tag}>" for tag in ("url", "logo") if (value := getattr(self, tag))]
        lines += [f"  {each.xml()}" for kind in (self.depends, self.rosdeps, self.platforms) for each in kind]
        if self.exports:
            lines.append("  <export>\n  " + "\n  ".join(each.xml() for each in self.exports) + "  </export>")
        if self.versioncontrol is not None:
            lines.append(f"  {self.versioncontrol.xml()}")
        return "\n".join([*lines, "</package>"])


def manifest_file(package: str, required: bool = True, env: Mapping[str, str] | None = None) -> str | None:
    """Return the path that a package's manifest.xml has, or would have.

    Raises:
        InvalidROSPkgException: there is no such package; or the file is required, but not there.
    """
    folder = get_pkg_dir(package, required)
    if folder is None:
        return None
    path = os.path.join(folder, MANIFEST_FILE)
    if required and not os.path.isfile(path):
        raise InvalidROSPkgException(f"\nPackage '{folder}' is improperly configured: no manifest file is present.\n")
    return path


def load_manifest(package: str) -> Manifest:
    """Return the manifest of a package; raises InvalidROSPkgException and ManifestException."""
    return parse_file(str(manifest_file(package)))


def parse_file(file: str) -> Manifest:
    """Return the manifest in a file; raises ValueError if there is none, and ManifestException."""
    manifest: Manifest = manifestlib.parse_file(Manifest(), file)
    return manifest


def parse(string: str | bytes, filename: str = "string") -> Manifest:
    """Return the manifest in a text; raises ManifestException."""
    manifest: Manifest = manifestlib.parse(Manifest(), string, filename)
    return manifest
