"""Makes pyros1's modules available to all programs in a Python environment, with a .pth file in its site-packages, and
stubs for editors.

See https://docs.python.org/3/library/site.html and PEP 561.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Mapping
from pathlib import Path

from pyros1.finding.library import Library
from pyros1.finding.python_modules import DROP_IN_START
from pyros1.ground.errors import Error

PTH_NAME = "pyros1-rospy.pth"
"""Name of the .pth file, which Python reads at startup. If pyros1 is uninstalled, the file has no effect."""

STUBS_FOLDER = "pyros1_rospy_stubs"
"""Name of the stubs folder, next to the .pth file, which adds the folder to `sys.path`; it has only .pyi files."""


class SiteError(Error):
    """The environment cannot be changed."""


def pth_file(folder: str | None = None) -> Path:
    """Return the path of the .pth file in this environment's site-packages folder, or in another one."""
    return Path(folder or sysconfig.get_path("purelib"), PTH_NAME)


def is_enabled(folder: str | None = None) -> bool:
    """Return whether programs in the environment can import the drop-in modules of this pyros1 installation."""
    try:
        return pth_file(folder).read_text(encoding="utf-8") == _pth_content()
    except OSError:
        return False


def enable(folder: str | None = None, environ: Mapping[str, str] | None = None) -> tuple[Path, list[str]]:
    """Write the .pth file, and stubs for pyros1's modules and for message packages.

    Args:
        folder: the site-packages folder; None for this environment's.
        environ: environment variables that contain the paths of ROS packages; None for ``os.environ``.

    Returns:
        The path of the .pth file, and an error message for each message package for which no stubs could be written.

    Raises:
        SiteError: the files cannot be written.
    """
    from pyros1.drop_in.stubs import write_stubs  # noqa: PLC0415 - not needed for the status

    file = pth_file(folder)
    try:
        errors = write_stubs(file.parent / STUBS_FOLDER, Library(os.environ if environ is None else environ))
        file.write_text(_pth_content(), encoding="utf-8")
    except OSError as error:
        raise SiteError(
            f"cannot write {error.filename or file.parent}: {error.strerror}; "
            "use a virtual environment of your own (python3 -m venv)"
        ) from error
    return file, errors


def disable(folder: str | None = None) -> bool:
    """Remove the .pth file and the stubs; return whether the .pth file existed.

    Raises:
        SiteError: the files cannot be removed.
    """
    file = pth_file(folder)
    try:
        if (file.parent / STUBS_FOLDER).is_dir():
            shutil.rmtree(file.parent / STUBS_FOLDER)
        file.unlink()
    except FileNotFoundError:
        return False
    except OSError as error:
        raise SiteError(f"cannot remove {error.filename}: {error.strerror}") from error
    return True


def installed_rospy() -> str | None:
    """Return the path of the rospy that programs in this environment currently import; None if there is none.

    Raises:
        SiteError: the interpreter does not respond in time.
    """
    code = "import importlib.util as u; s = u.find_spec('rospy'); print(s.origin if s else '')"
    try:
        result = subprocess.run(
            [sys.executable, "-c", code],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            stdin=subprocess.DEVNULL,
            text=True,
            timeout=30,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise SiteError(f"{sys.executable} does not start within 30 s") from None
    return result.stdout.strip() or None


def _pth_content() -> str:
    call = "sys.path.append(p), __import__('pyros1_modules').install(), sys.path.remove(p)"
    # Python executes a line of a .pth file only if it starts with "import"; so all of this is one line, in ASCII.
    return f"{STUBS_FOLDER}\nimport os, sys; p = {DROP_IN_START!a}; os.path.isdir(p) and ({call})\n"
