"""Calls that list, step through and record bags."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views.view import number_arg, string_arg

_MAX_TOPICS = 5_000
_MAX_SECONDS = 4.29e9  # the sum of two such times in nanoseconds fits in 64 bits


def files(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Return the contents of a folder; see `pyros1.web.bags.bag_folders.BagFolders.listing`. Args: folder."""
    return robot.bags.bag_folders.listing(string_arg(args, "folder", ""))


def step(robot: Robot, args: Mapping[str, Any]) -> float | None:
    """Return the time of the next or previous message on any of the topics. Args: path, time, topics, forward.

    Times are in seconds since the bag's start.
    """
    from pyros1.web.views.bag.file import topics_arg  # noqa: PLC0415 - rarely needed

    bag = robot.bags.borrow(string_arg(args, "path"))
    try:
        time = number_arg(args, "time", -_MAX_SECONDS, _MAX_SECONDS, 0.0)
        return bag.adjacent_time(
            time, bag.recorded_names(topics_arg(args, _MAX_TOPICS)), args.get("forward") is not False
        )
    finally:
        robot.bags.release(bag)


def record(robot: Robot, args: Mapping[str, Any]) -> None:
    """Start recording. Args: folder, prefix, compression, topics (their names, or null for all)."""
    from pyros1.web.bags.recording import Recording  # noqa: PLC0415
    from pyros1.web.views.bag.file import topics_arg  # noqa: PLC0415

    selected = None if args.get("topics") is None else topics_arg(args, _MAX_TOPICS)
    if selected is not None and not selected:
        raise RequestError("choose a topic to record")
    for name in selected or ():
        robot.check_visible(name)
    folder = robot.bags.bag_folders.find_folder(string_arg(args, "folder"))
    prefix, compression = string_arg(args, "prefix", ""), string_arg(args, "compression", "none")
    node = robot.node
    robot.bags.record(lambda: Recording(node, folder, prefix, selected, compression, robot.access.may_see))


def stop(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Stop the recording and return its status."""
    recording = robot.bags.recording
    if recording is None:
        raise RequestError("nothing is being recorded")
    recording.stop()
    return recording.status()


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {
    "files": files,
    "step": step,
    "record": record,
    "stop": stop,
}
CHANGES = frozenset({"record", "stop"})
