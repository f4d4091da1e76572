"""roslib's names for rospkg's package manifests."""

from __future__ import annotations

import os
from collections.abc import Mapping

from rospkg import MANIFEST_FILE, Manifest, RosPack, parse_manifest_file
from rospkg import InvalidManifest as ManifestException

from pyros1.drop_in.module_attributes import module_getattr
from roslib.packages import InvalidROSPkgException, get_pkg_dir

_REASON = "use rospkg.RosPack().get_manifest, whose dependencies have names"

__getattr__ = module_getattr(
    __name__, parse=_REASON, Depend=_REASON, ROSDep=_REASON, Export=_REASON, VersionControl=_REASON
)


def manifest_file(package: str, required: bool = True, env: Mapping[str, str] | None = None) -> str | None:
    """Return the path of a package's manifest.xml.

    Raises:
        InvalidROSPkgException: there is no such package, or it has no manifest.xml although that is required.
    """
    folder = get_pkg_dir(package, required)
    path = folder and os.path.join(folder, MANIFEST_FILE)
    if path and required and not os.path.isfile(path):
        raise InvalidROSPkgException(f"Package '{folder}' has no {MANIFEST_FILE}")
    return path


def load_manifest(package: str) -> Manifest:
    """Return the manifest of a package; raises ResourceNotFound, and ManifestException if the manifest is invalid."""
    return RosPack.get_instance().get_manifest(package)


def parse_file(file: str) -> Manifest:
    """Return the manifest in a file; raises ManifestException if it is invalid."""
    return parse_manifest_file(*os.path.split(os.path.abspath(file)))
