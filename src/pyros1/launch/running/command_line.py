"""Makes the command line and the environment of a planned node (X83, X84)."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path

from pyros1.finding.packages import OWN_PACKAGES
from pyros1.finding.python_modules import modules_environment, system_python
from pyros1.ground.errors import LaunchError, PackageNotFoundError
from pyros1.launch.plan import NodePlan
from pyros1.launch.reading.resources import PackageFinder
from pyros1.launch.running.shebang import script_problem

_PACKAGE_FOLDER = Path(__file__).resolve().parents[2]


def locate(package: str, executable_name: str, packages: PackageFinder) -> Path:
    """Return the path of a node's executable.

    Raises:
        LaunchError: the package is unknown, or has no executable with this name.
    """
    try:
        executables = packages.find_executable(package, executable_name)
    except PackageNotFoundError as error:
        raise LaunchError(str(error)) from error
    if not executables:
        raise LaunchError(
            f"Cannot locate node of type [{executable_name}] in package [{package}]. Make sure file exists in package "
            f"path and permission is set to executable (chmod +x)"
        )
    return executables[0]


def check_prefix(node: NodePlan, environ: Mapping[str, str]) -> None:
    """Check that the program of a ``launch-prefix`` exists.

    Raises:
        LaunchError: the program is not on the PATH.
    """
    if not node.prefix:
        return
    from shutil import which  # noqa: PLC0415 - slow: it imports all compression modules

    if which(node.prefix[0], path={**environ, **node.env}.get("PATH")) is None:
        raise LaunchError(f"launch-prefix: program [{node.prefix[0]}] not found on the PATH")


def check_script(node: NodePlan, executable: Path, environ: Mapping[str, str]) -> None:
    """Check that the system can start a node's executable if the executable is a script.

    Raises:
        LaunchError: the system cannot start the script; the message says why.
    """
    env = {**environ, **node.env}
    if node.prefix or executable_words(executable, env)[0] != str(executable):  # another program runs the executable
        return
    problem = script_problem(executable, env)
    if problem:
        raise LaunchError(f"cannot run {executable}: {problem}")


def is_own(executable: Path) -> bool:
    """Return whether a file is in one of pyros1's own packages."""
    return os.path.realpath(executable).startswith(OWN_PACKAGES + os.sep)


def executable_words(executable: Path, environ: Mapping[str, str] = os.environ) -> list[str]:
    """Return the command line that starts an executable.

    pyros1's own Python nodes run in this interpreter, since installers may remove the executable bit, and other
    interpreters may not have pyros1. Scripts from the system's packages run in the system's interpreter.
    """
    if is_own(executable) and _is_python(executable):
        return [sys.executable, str(executable)]
    python = system_python(executable, environ)
    return [python, str(executable)] if python else [str(executable)]


def _is_python(path: Path) -> bool:
    if path.suffix == ".py":
        return True
    try:
        with path.open("rb") as stream:
            first_line = stream.readline(200)
    except OSError:
        return False
    return first_line.startswith(b"#!") and b"python" in first_line


def node_words(node: NodePlan, executable: Path, environ: Mapping[str, str] = os.environ) -> list[str]:
    """Return the command line of a node, without ``__log``."""
    remaps = [f"{old}:={new}" for old, new in node.remappings]
    words = executable_words(executable, {**environ, **node.env})
    return [*node.prefix, *words, *node.args, *remaps, f"__name:={node.name}"]


def node_environment(node: NodePlan, executable: Path, environ: Mapping[str, str], master_uri: str) -> dict[str, str]:
    """Return the environment of a node.

    Args:
        node: the planned node.
        executable: path of the node's executable.
        environ: this process's environment.
        master_uri: the value of ROS_MASTER_URI.
    """
    env = {**environ, "ROS_MASTER_URI": master_uri}
    env.pop("ROS_NAMESPACE", None)
    if node.namespace.strip("/"):
        env["ROS_NAMESPACE"] = node.namespace.rstrip("/")
    env.update(node.env)
    return {**env, **program_environment(executable, env)}


def program_environment(executable: Path, environ: Mapping[str, str]) -> dict[str, str]:
    """Return additional environment variables for a program, so that Python programs find pyros1's modules."""
    if is_own(executable):
        return own_python_environment(environ)
    return modules_environment(environ) if _is_python(executable) else {}


def own_python_environment(environ: Mapping[str, str]) -> dict[str, str]:
    """Return the variables that pyros1's own nodes need to find pyros1, and to write output without delay."""
    source_folder = _PACKAGE_FOLDER.parent
    changes = {"PYTHONUNBUFFERED": environ.get("PYTHONUNBUFFERED") or "1"}
    if source_folder.name not in ("site-packages", "dist-packages"):  # not installed: run from a source tree
        paths = [str(source_folder), *(part for part in environ.get("PYTHONPATH", "").split(os.pathsep) if part)]
        changes["PYTHONPATH"] = os.pathsep.join(dict.fromkeys(paths))
    return changes
