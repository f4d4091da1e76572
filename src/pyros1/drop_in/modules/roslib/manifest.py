"""Manifests of packages, from before rospkg."""

from __future__ import annotations

import os
from collections.abc import Mapping

from rospkg.common import MANIFEST_FILE
from rospkg.manifest import Depend, Export, Manifest, parse_manifest, parse_manifest_file
from rospkg.manifest import InvalidManifest as ManifestException
from rospkg.manifest import RosDep as ROSDep

from pyros1.drop_in.missing import missing
from roslib.packages import InvalidROSPkgException, get_pkg_dir

__getattr__ = missing(__name__)


def manifest_file(package: str, required: bool = True, env: Mapping[str, str] | None = None) -> str | None:
    """Return the path of a package's manifest.xml; raises InvalidROSPkgException if it must be there and is not."""
    folder = get_pkg_dir(package, required)
    path = os.path.join(folder, MANIFEST_FILE) if folder else ""
    if os.path.isfile(path):
        return path
    if required:
        raise InvalidROSPkgException(f"Package '{package}' is improperly configured: no manifest file is present.")
    return None


def load_manifest(package: str) -> Manifest:
    """Return the manifest of a package; raises InvalidROSPkgException and ManifestException."""
    return parse_manifest_file(str(get_pkg_dir(package)), MANIFEST_FILE)


def parse_file(file: str) -> Manifest:
    """Return the manifest in a file."""
    folder, name = os.path.split(file)
    return parse_manifest_file(folder, name)


def parse(string: str, filename: str = "string") -> Manifest:
    """Return the manifest in a text."""
    return parse_manifest(MANIFEST_FILE, string, filename)
