"""Files of packages."""

from __future__ import annotations

import os
from collections.abc import Callable

from rospkg import RosPack

from pyros1.drop_in.missing import missing

__getattr__ = missing(__name__)


def list_package_resources_by_dir(
    package_dir: str, include_depends: bool, subdir: str, rfilter: Callable[[str], bool] = os.path.isfile
) -> list[str]:
    """Return the names of the files in a folder of a package.

    Args:
        package_dir: the package's folder.
        include_depends: whether those of the packages that it needs count, too, as ``package/name``.
        subdir: the folder.
        rfilter: tells whether a path counts.
    """
    folder = os.path.join(package_dir, subdir)
    names = os.listdir(folder) if os.path.isdir(folder) else []
    found = [name for name in names if rfilter(os.path.join(folder, name))]
    if include_depends:
        rospack = RosPack.get_instance()
        from rospkg import get_package_name

        for package in rospack.get_depends(str(get_package_name(package_dir)), implicit=False):
            inner = list_package_resources(package, False, subdir, rfilter)
            found += [f"{package}/{name}" for name in inner]
    return found


def list_package_resources(
    package: str, include_depends: bool, subdir: str, rfilter: Callable[[str], bool] = os.path.isfile
) -> list[str]:
    """Return the names of the files in a folder of a package; arguments as above, but the package's name."""
    return list_package_resources_by_dir(RosPack.get_instance().get_path(package), include_depends, subdir, rfilter)
