"""Examples to copy: files in examples/, with their descriptions.

The folder of an example has a folder for each face, ``node`` (`pyros1.Node`) and ``rospy``, and one for shared files.
The files are those of a package called `PLACEHOLDER`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from pyros1.ground.errors import Error
from pyros1.ground.suggest import did_you_mean

EXAMPLES = Path(__file__).parent / "examples"
FACES = ("node", "rospy")
"""The faces: `pyros1.Node`, and rospy for programs that should also run with other ROS 1 installations."""
SHARED = "both"
PLACEHOLDER = "my_package"
"""The name of the package in the files."""
_PYTHON = "python3 "


class ExampleError(Error):
    """An example does not exist."""


class Example(NamedTuple):
    """An example.

    Attributes:
        name: its name in commands.
        about: its description, in one line.
        depends: packages that it needs with any face.
        tries: what to type after ``pyros1 `` to see it work, with `PLACEHOLDER` for the package. A line that starts
            with ``python3`` is a complete command.
        rospy_depends: packages that it needs with the face rospy, in addition to rospy itself.
    """

    name: str
    about: str
    depends: tuple[str, ...]
    tries: tuple[str, ...]
    rospy_depends: tuple[str, ...] = ()

    @property
    def faces(self) -> tuple[str, ...]:
        """The faces that are available."""
        return tuple(face for face in FACES if (EXAMPLES / self.name / face).is_dir())

    def files(self, face: str, package: str) -> dict[str, str]:
        """Return its files: path in the package -> text.

        Args:
            face: one of `faces`.
            package: name of the package for which they are.
        """
        found = {}
        for part in (SHARED, face):
            place = EXAMPLES / self.name / part
            for base, folders, names in os.walk(place):
                folders[:] = sorted(set(folders) - {"__pycache__"})
                for name in sorted(names):
                    path = Path(base, name)
                    text = path.read_text(encoding="utf-8").replace(PLACEHOLDER, package)
                    found[path.relative_to(place).as_posix().replace(PLACEHOLDER, package)] = text
        return found

    def needs(self, face: str) -> list[str]:
        """Return the packages that it depends on with this face."""
        return [*self.depends, *(["rospy", *self.rospy_depends] if face == "rospy" else [])]


CATALOGUE = (
    Example(
        "publisher", "publishes messages at a rate", ("std_msgs",),
        ("run my_package publisher.py", "topic echo numbers"),
    ),
    Example(
        "subscriber", "receives messages in a class that keeps state", ("std_msgs",),
        ("run my_package subscriber.py", "topic pub -r 2 numbers std_msgs/Float64 1.5"),
    ),
    Example(
        "service", "a service with its own type, which may reject requests, and a client", (),
        ("run my_package divide_server.py", "run my_package divide_client.py 7 2"),
    ),
    Example(
        "timer", "calls functions periodically, and once after a delay", ("std_msgs",),
        ("run my_package blinker.py",),
    ),
    Example(
        "parameters", "reads parameters, also from a file, and reacts to changes", ("geometry_msgs",),
        ("launch my_package speed_limiter.launch", "param set /speed_limiter/limits/linear 0.2"),
    ),
    Example(
        "action", "an action with its own type, feedback and cancelling, and a client", ("actionlib_msgs",),
        ("run my_package count_server.py", "run my_package count_client.py 20"), ("actionlib",),
    ),
    Example(
        "reconfigure", "settings that tools can change while the node is running", ("std_msgs",),
        ("run my_package oscillator.py", "dynparam set oscillator amplitude 2.5"), ("dynamic_reconfigure",),
    ),
    Example(
        "tf_broadcaster", "publishes frames: a moving one and a static one", ("geometry_msgs",),
        ("run my_package tf_broadcaster.py", "tf tree"), ("tf2_ros",),
    ),
    Example(
        "tf_listener", "looks up where one frame is relative to another", (),
        ("run my_package tf_listener.py world laser", "tf static_transform_publisher 1 0 0.5 0 0 0 world laser"),
        ("tf2_ros",),
    ),
    Example(
        "urdf", "a moving robot with links and joints",
        ("joint_state_publisher", "robot_state_publisher", "sensor_msgs"),
        ("launch my_package arm.launch", "web scene --open"),
    ),
    Example(
        "image", "finds edges in images, with numpy", ("sensor_msgs",),
        ("run my_package picture_source.py", "run my_package edges.py", "web image --open"),
    ),
    Example(
        "cloud", "filters point clouds, with numpy", ("sensor_msgs",),
        ("run my_package cloud_source.py", "run my_package cloud_filter.py", "topic hz filtered"),
    ),
    Example(
        "bag", "writes a bag, and analyses it with pandas", ("nav_msgs",),
        ("run my_package write_bag.py drive.bag", "run my_package analyse_bag.py drive.bag"), ("rosbag",),
    ),
    Example(
        "asyncio", "subscribes, publishes and offers a service in an asyncio program", ("std_msgs", "std_srvs"),
        ("run my_package averager.py", "topic pub -r 5 numbers std_msgs/Float64 1.5"),
    ),
    Example(
        "test", "tests of a node, with pytest and with pyros1 test", ("rostest", "std_msgs"),
        ("test my_package doubler.test", "python3 -m pytest my_package/tests"),
    ),
    Example(
        "launch", "a launch file with all the usual elements, and its nodes", ("std_msgs",),
        ("launch my_package robot.launch", "launch my_package robot.launch robot:=r2 rate:=5"),
    ),
)  # fmt: skip


def example(name: str, face: str = FACES[0]) -> Example:
    """Return an example.

    Args:
        name: its name.
        face: the requested face.

    Raises:
        ExampleError: the example does not exist, or lacks the face; the text names the available ones.
    """
    known = {each.name: each for each in CATALOGUE}
    if name not in known:
        hint = did_you_mean(name, known)
        raise ExampleError(f"there is no example '{name}'{hint}; the examples are: {', '.join(known)}")
    found = known[name]
    if face not in found.faces:
        raise ExampleError(f"the example '{name}' has no face '{face}', only: {', '.join(found.faces)}")
    return found


def builds_with(package: str) -> bool:
    """Return whether stock ROS needs a package at build time: it has messages, or CMake functions.

    Other packages are only needed at run time.
    """
    return package.endswith(("_msgs", "_srvs")) or package in ("dynamic_reconfigure", "rospy")


def gather(examples: Sequence[Example], face: str, package: str) -> dict[str, str]:
    """Return the combined files of several examples: path in the package -> text, with a README.md that lists them.

    Args:
        examples: the examples.
        face: a face that all of them have.
        package: name of the package for which they are.
    """
    files: dict[str, str] = {}
    for each in examples:
        files.update(each.files(face, package))
    return {"README.md": _readme(examples, package), **files}


def tries(examples: Sequence[Example], package: str) -> list[str]:
    """Return the commands to try out the examples."""
    lines = [line.replace(PLACEHOLDER, package) for each in examples for line in each.tries]
    return [line if line.startswith(_PYTHON) else f"pyros1 {line}" for line in lines]


def _readme(examples: Sequence[Example], package: str) -> str:
    lines = [f"# {package}", ""]
    for each in examples:
        lines += [f"{each.name}: {each.about}.", "", *(f"    {line}" for line in tries([each], package)), ""]
    lines += [
        "Nothing needs to be built: pyros1 finds the package from its parent folder, and from inside it. Each program",
        "says at the top what it does and how to run it.",
        "",
    ]
    return "\n".join(lines)
