"""Helpers for programs that launch files."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pyros1.launch.scripting as _scripting
from pyros1.finding.packages import enclosing_package
from pyros1.launch.reading.cli_arguments import find_launch_files, parse_arguments
from pyros1.launch.reading.depends import declared_depends, file_needs, find_undeclared
from pyros1.launch.reading.loader import absolute_files, load_plan
from pyros1.launch.reading.system_resources import make_resources
from roslaunch.core import RLException, rl_errors
from roslaunch.printing import printerrlog

DEFAULT_MASTER_PORT = 11311
_terminal_name = [""]

__all__ = [
    "DEFAULT_MASTER_PORT",
    "change_terminal_name",
    "check_log_disk_usage",
    "check_roslaunch",
    "get_or_generate_uuid",
    "print_file_list",
    "resolve_launch_arguments",
    "update_terminal_name",
]


@rl_errors
def resolve_launch_arguments(args: Iterable[str]) -> list[str]:
    """Return the paths of the launch files on a command line, ``PACKAGE FILE`` or ``FILE...``. Words with ``:=`` are
    ignored.

    Raises:
        RLException: a file does not exist.
    """
    return find_launch_files([word for word in args if ":=" not in word], make_resources())


def get_or_generate_uuid(options_runid: str | None, options_wait_for_master: bool) -> str:
    """Return the run id of the running master, or a new one.

    Args:
        options_runid: a run id, which is returned unless it is empty.
        options_wait_for_master: whether to wait until a master is running.
    """
    return _scripting.get_or_generate_uuid(options_runid, options_wait_for_master)


def change_terminal_name(args: list[str], is_core: bool) -> None:
    """Set the title of the terminal's window."""
    _terminal_name[0] = "roscore" if is_core else ",".join(args)
    _set_title(_terminal_name[0])


def update_terminal_name(ros_master_uri: str) -> None:
    """Add the master's address to the title of the terminal's window."""
    if _terminal_name[0]:
        _set_title(f"{_terminal_name[0]} {ros_master_uri}")


def _set_title(text: str) -> None:
    if sys.stdout.isatty():
        sys.stdout.write(f"\033]2;{''.join(filter(str.isprintable, text))}\007")


def check_log_disk_usage() -> None:
    """Warn if log files take more than 1 GB."""
    from pyros1.launch.running.logs import log_folder

    folder = log_folder(os.environ)
    size = sum(file.lstat().st_size for file in folder.rglob("*") if file.is_file()) if folder.is_dir() else 0
    if size > 1 << 30:
        print(f"WARNING: disk usage in log directory [{folder}] is over 1GB.")


@rl_errors
def print_file_list(roslaunch_files: Any) -> None:
    """Print all files that a launch reads; raises RLException if one cannot be read."""
    plan = load_plan(list(roslaunch_files), {}, make_resources())
    print("\n".join(absolute_files(plan.files)))


def check_roslaunch(f: str, use_test_depends: bool = False, ignore_unset_args: bool = False) -> str | None:
    """Check that a launch file can be read, that its nodes exist, and that its package declares their packages.

    Args:
        f: the file's path.
        use_test_depends: whether ``<test_depend>`` counts as a declaration.
        ignore_unset_args: whether to accept arguments without values.

    Returns:
        The errors; None if there are none.
    """
    from roslib.packages import find_node
    from rospkg import ResourceNotFound

    from roslaunch.config import load_config_default

    try:
        config = load_config_default([f], DEFAULT_MASTER_PORT, ignore_unset_args=ignore_unset_args)
    except RLException as error:
        return str(error)
    needs = file_needs(load_plan([f], parse_arguments(sys.argv), make_resources(), problems=[]))
    declared = {name for need in needs for name in declared_depends(enclosing_package(Path(need.file))[0])}
    errors = []
    for package, names_found in find_undeclared(needs, test_depends=use_test_depends).items():
        names = set(names_found)
        text = f"Missing package dependencies: {package}/package.xml: {', '.join(sorted(names))}"
        if names - declared:
            printerrlog(text)
            errors.append(text)
        elif names:
            printerrlog(f"{text} (notify upstream maintainer)")
    nodes = [node for need in needs for node in need.nodes]
    unknown_packages = {package for package, _ in nodes if package not in make_resources().packages.list()}
    errors += [
        f"cannot find package [{package}] for node [{node_type}]"
        for package, node_type in nodes
        if package in unknown_packages
    ]
    for package, node_type in nodes:
        try:
            if not find_node(package, node_type):
                errors.append(f"cannot find node [{node_type}] in package [{package}]")
        except ResourceNotFound as error:
            errors.append(f"unable to find node [{package}/{node_type}]: {error}")
    errors += [f"ROSLaunch config error: {error}" for error in config.config_errors]
    return "\n".join(errors) if errors else None
