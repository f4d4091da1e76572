"""Where launching looks for packages: where everything else does, and among Python's packages."""

from __future__ import annotations

import os
import sys
import sysconfig
from collections.abc import Mapping
from pathlib import Path

from pyros1.msgs.packages import PackageIndex, stock_installs


def package_index(environ: Mapping[str, str]) -> PackageIndex:
    """Return a finder that also knows install and devel spaces and Python packages that declare a ROS package.

    A Python package declares one by a ``package.xml`` in its folder, or by installing ``share/NAME/package.xml``. The
    order is: ``ROS_PACKAGE_PATH``, the spaces of ``CMAKE_PREFIX_PATH``, stock installations, Python packages, pyros1's
    own.

    Args:
        environ: environment variables.
    """
    spaces = [Path(part, "share") for part in environ.get("CMAKE_PREFIX_PATH", "").split(os.pathsep) if part]
    python = [Path(sys.prefix, "share"), *(Path(sysconfig.get_path(name)) for name in ("purelib", "platlib"))]
    return PackageIndex(environ, installs=list(dict.fromkeys([*spaces, *stock_installs(), *python])))
