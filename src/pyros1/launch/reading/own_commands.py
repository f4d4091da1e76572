"""Finds the commands in launch files that run pyros1's own programs, and determines their environment."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Mapping

from pyros1.finding.packages import OWN_PACKAGES, PackageIndex
from pyros1.ground.errors import PackageNotFoundError
from pyros1.launch.reading.xacro_tool import xacro_words
from pyros1.launch.running.command_line import own_python_environment

_STOCK_TOOLS = frozenset(["rosnode", "rospack", "rosparam", "rosrun", "rosservice", "rostopic", "rosversion"])


def own_words(words: list[str]) -> list[str]:
    """Return the words to run for a command: ``words`` itself, or the command line of a pyros1 program instead.

    ``rosrun xacro xacro`` is treated like ``$(find xacro)/xacro``. A tool such as ``rosrun`` or ``rosversion`` that is
    not installed as a command is run by ``pyros1``.
    """
    if len(words) > 2 and words[:2] == ["rosrun", "xacro"]:
        words = [_in_xacro(words[2]), *words[3:]] if _is_xacro_own() else words
    if words and words[0] in _STOCK_TOOLS and shutil.which(words[0]) is None:
        return [sys.executable, "-m", "pyros1", *words]
    return xacro_words(words)


def _in_xacro(program: str) -> str:
    return os.path.join(OWN_PACKAGES, "xacro", program)


def _is_xacro_own() -> bool:
    try:
        return os.path.realpath(PackageIndex(os.environ).find("xacro")) == os.path.realpath(_in_xacro(""))
    except PackageNotFoundError:
        return False


def own_environment(words: list[str], environ: Mapping[str, str]) -> dict[str, str] | None:
    """Return the environment for a command that runs pyros1's own programs; None for any other command.

    A command can be a wrapper: ``env_run SETTINGS $(find xacro)/xacro ...`` sets variables, then runs xacro. The first
    line of pyros1's programs names ``python3``, so this interpreter must be the first ``python3`` on the ``PATH``.
    """
    if not words or (words[0] != sys.executable and not any(word.startswith(OWN_PACKAGES) for word in words)):
        return None
    path = os.pathsep.join(filter(None, (os.path.dirname(sys.executable), environ.get("PATH", ""))))
    return {**environ, **own_python_environment(environ), "PATH": path}
