"""The ``xacro`` program in a process of its own: ``python -m pyros1.launch.reading.xacro_tool ARGUMENTS``.

The program is that of Python's package index (``pip install pyros1[xacro]``). It asks ROS 2's index for packages; here
that question is answered by pyros1's package finder, so ``$(find pkg)`` means in a xacro file what it means in a
launch file.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
import types

from pyros1.errors import PackageNotFoundError
from pyros1.finding.packages import OWN_PACKAGES, PackageIndex

MISSING = "xacro is not installed: pip install pyros1[xacro]"
_NAMES = ("xacro", "xacro.py")


def xacro_words(words: list[str]) -> list[str]:
    """Return the words to run for a command, which are others if it is xacro and xacro is to be run by pyros1.

    That is so for ``$(find xacro)/xacro`` where pyros1's own package is the one found, and for a plain ``xacro`` if
    this interpreter has it, or if nothing else would be run.
    """
    if not words or os.path.basename(words[0]) not in _NAMES:
        return words
    folder = os.path.dirname(words[0])
    if folder:
        ours = os.path.realpath(folder) == os.path.realpath(os.path.join(OWN_PACKAGES, "xacro"))
    else:
        found = importlib.util.find_spec("xacro")
        ours = (found is not None and found.origin is not None) or shutil.which(words[0]) is None
    return [sys.executable, "-m", __name__, *words[1:]] if ours else words


def main() -> int:
    """Run xacro with this process's arguments; return the exit code."""
    finder = PackageIndex(os.environ)

    def get_package_share_directory(name: str) -> str:
        return str(finder.find(name))

    packages = types.ModuleType("ament_index_python.packages")
    vars(packages).update(
        get_package_share_directory=get_package_share_directory, PackageNotFoundError=PackageNotFoundError
    )
    parent = types.ModuleType("ament_index_python")
    vars(parent).update(packages=packages, get_package_share_directory=get_package_share_directory, __path__=[])
    sys.modules.update({parent.__name__: parent, packages.__name__: packages})
    try:
        import xacro  # type: ignore[import-untyped,import-not-found,unused-ignore]  # noqa: PLC0415 - an extra
    except ImportError:
        sys.stderr.write(MISSING + "\n")
        return 1
    try:
        xacro.main()
    except PackageNotFoundError as error:
        sys.stderr.write(f"xacro: {error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
