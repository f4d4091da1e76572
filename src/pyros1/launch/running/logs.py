"""The folders and names of log files (X86, N29, N30)."""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping
from pathlib import Path
from typing import TextIO

from pyros1.ground.errors import LaunchError
from pyros1.ground.terminal_text import one_line


def ros_home(environ: Mapping[str, str]) -> Path:
    """Return ``$ROS_HOME`` or ``~/.ros``."""
    home = environ.get("ROS_HOME")
    return Path(home) if home else Path(os.path.expanduser("~")) / ".ros"


def log_folder(environ: Mapping[str, str]) -> Path:
    """Return ``$ROS_LOG_DIR`` or ``$ROS_HOME/log``."""
    folder = environ.get("ROS_LOG_DIR")
    return Path(folder) if folder else ros_home(environ) / "log"


def make_run_folder(environ: Mapping[str, str], run_id: str) -> Path:
    """Create the log folder of a run, and the link ``latest`` to it.

    Args:
        environ: environment variables.
        run_id: name of the folder. It is read from the master, where any client can set it.

    Raises:
        LaunchError: the name would lead outside the log folder.
        OSError: the folder cannot be created.
    """
    if "/" in run_id or run_id.startswith(".") or "\0" in run_id or not run_id:
        raise LaunchError(f"not a valid run id: {one_line(repr(run_id))}")
    folder = log_folder(environ) / run_id
    folder.mkdir(parents=True, exist_ok=True)
    _update_link(log_folder(environ) / "latest", folder)
    return folder


def run_log(folder: Path) -> Path:
    """Return the path of this launcher's own log file in a run's folder."""
    return folder / f"roslaunch-{socket.gethostname()}-{os.getpid()}.log"


def open_run_log(environ: Mapping[str, str], run_id: str) -> tuple[Path, TextIO]:
    """Create a run's folder, and open this launcher's own log file in it.

    Returns:
        The folder, and the file, opened for appending.

    Raises:
        LaunchError: the run id is not valid, or the log file cannot be written.
    """
    try:
        folder = make_run_folder(environ, run_id)
        return folder, run_log(folder).open("a", encoding="utf-8", errors="replace")
    except OSError as error:
        raise LaunchError(
            f"cannot write log files: {error.strerror}: {error.filename}. "
            "Set ROS_LOG_DIR (or ROS_HOME, for other files too) to a folder with write permission"
        ) from error


def _update_link(link: Path, target: Path) -> None:
    try:
        if link.is_symlink() and os.readlink(link) == str(target):
            return
        if link.exists() and not link.is_symlink():
            return  # another file has this name
        temporary = link.with_name(f"latest.{os.getpid()}")
        temporary.unlink(missing_ok=True)
        temporary.symlink_to(target)
        os.replace(temporary, link)
    except OSError:
        pass  # symbolic links are not supported here, but the logs do not depend on them
