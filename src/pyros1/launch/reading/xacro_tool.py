"""Runs ``xacro`` in a separate process: ``python -m pyros1.launch.reading.xacro_tool ARGUMENTS``.

This is the xacro from PyPI, which is installed with pyros1 and looks for packages in ROS 2's index. This module
replaces that index with pyros1's package finder, so ``$(find pkg)`` means the same in xacro files and launch files.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
import types
import xml.parsers.expat  # noqa: F401 - xacro uses it when it reports an error, but does not import it

from pyros1.finding.packages import OWN_PACKAGES, PackageIndex
from pyros1.ground.errors import PackageNotFoundError

MISSING_MESSAGE = "xacro is not installed: pip install xacro"
_XACRO_NAMES = ("xacro", "xacro.py")
_OPTIONS_WITH_VALUE = ("-o", "--verbosity", "--root-dir")
"""Options of xacro that are followed by a value."""


def xacro_words(words: list[str]) -> list[str]:
    """Return the words to run for a command: ``words`` itself, or the command line of this module if it replaces xacro.

    This module runs ``$(find xacro)/xacro`` if that is in pyros1's own package, and a plain ``xacro`` if this
    interpreter has the module xacro, or if no such program is installed.
    """
    if not words or os.path.basename(words[0]) not in _XACRO_NAMES:
        return words
    folder = os.path.dirname(words[0])
    if folder:
        uses_own = os.path.realpath(folder) == os.path.realpath(os.path.join(OWN_PACKAGES, "xacro"))
    else:
        module_spec = importlib.util.find_spec("xacro")
        uses_own = (module_spec is not None and module_spec.origin is not None) or shutil.which(words[0]) is None
    return [sys.executable, "-m", __name__, *words[1:]] if uses_own else words


def missing_input(words: list[str]) -> str:
    """Return the input file on xacro's command line if that file does not exist; an empty string if it exists, or if
    the input file cannot be determined.
    """
    names, expects_value = [], False
    for word in words:
        if not expects_value and not word.startswith("-") and ":=" not in word:
            names.append(word)
        expects_value = not expects_value and word in _OPTIONS_WITH_VALUE
    if len(names) != 1 or os.path.exists(names[0]) or any(word.startswith("--root-dir") for word in words):
        return ""
    return names[0]


def main() -> int:
    """Run xacro with this process's arguments and return the exit code."""
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
        import xacro  # type: ignore[import-untyped,import-not-found,unused-ignore]  # noqa: PLC0415 - after the modules that it needs were replaced
    except ImportError:
        sys.stderr.write(MISSING_MESSAGE + "\n")
        return 1
    missing = missing_input(sys.argv[1:])
    if missing:
        sys.stderr.write(f"xacro: no such file: {missing}\n")
        return 2
    try:
        xacro.main()
    except PackageNotFoundError as error:
        sys.stderr.write(f"xacro: {error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
