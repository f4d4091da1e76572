"""By hand: prints which standard ROS 2 types are in ROS 1 too, and which differ; see interop/ros2.md.

`python interop/ros2/pairs.py` takes the types of the wheels that compare_rclpy.py needs, in the same environment;
`python interop/ros2/pairs.py humble` takes the messages of a distribution that rosbags knows.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

from pyros1.finding.library import Library
from pyros1.ground.errors import Error
from pyros1.msgs.spec import MessageSpec
from pyros1.ros2_types.counterparts import Counterparts
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.installed import InstalledTypes
from pyros1.ros2_types.model import Types
from pyros1.ros2_types.transcoding.transcoder import Transcoder

SHARE = Path(sys.prefix) / "share"
PARTS = {"srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}


class Pair(NamedTuple):
    """A type that both sides have: its names, what converts it, and what the sides do not have in common."""

    ros1: str
    ros2: str
    transcoder: Transcoder | None
    problem: str

    def difference(self) -> str:
        """Return what the bridge does about differences; empty if there are none."""
        if self.transcoder is None:
            return f"not bridged: {self.problem}"
        only = {"to ROS 2": self.transcoder.only_ros1, "to ROS 1": self.transcoder.only_ros2}
        return "; ".join(f"left out {way}: {', '.join(names)}" for way, names in only.items() if names)


def find_pairs(types: Types) -> Iterator[Pair]:
    """Yield the types that both sides have; a service or action is as many as its parts."""
    counterparts, library = Counterparts(types), ros1_library()
    for ros2 in sorted(types):
        folder, short = ros2.split("/")[1:]
        suffix = next((part for part in PARTS.get(folder, ()) if short.endswith(f"_{part}")), "")
        if folder != "msg" and not suffix:
            continue
        ros1 = counterparts.to_ros1(ros2)
        try:
            specs = _specs(library, ros1, folder, suffix)
        except Error:
            continue  # ROS 1 has no such type
        try:
            yield Pair(ros1, ros2, Transcoder(ros1, specs, ros2, types), "")
        except Error as error:
            yield Pair(ros1, ros2, None, str(error))


def _specs(library: Library, ros1: str, folder: str, suffix: str) -> Mapping[str, MessageSpec]:
    """Return the definition of a ROS 1 type, and of all types that it uses."""
    if folder == "srv":
        service = library.service(ros1.removesuffix(suffix))
        spec = service.request if suffix == "Request" else service.response
    else:
        spec = library.message(ros1)
    names = library.digests.dependencies(spec)
    return {spec.name: spec} | {name: library.message(name) for name in names}


def ros1_library() -> Library:
    """Return the definitions of Debian's packages, where they are installed, and those that come with pyros1."""
    return Library({}, installs=[folder for folder in ("/usr/share", "/opt/ros/noetic/share") if Path(folder).is_dir()])


def known_types(distribution: str | None) -> Types:
    """Return the types of a distribution, or of the wheels in this environment."""
    if distribution is not None:
        return distribution_types(distribution)
    return InstalledTypes([SHARE])


if __name__ == "__main__":
    pairs = [*find_pairs(known_types(sys.argv[1] if sys.argv[1:] else None))]
    for pair in pairs:
        if text := pair.difference():
            print(f"| {pair.ros1} | {pair.ros2} | {text} |")
    same = sum(not pair.difference() for pair in pairs)
    print(f"{len(pairs)} pairs; {same} with the same fields")
