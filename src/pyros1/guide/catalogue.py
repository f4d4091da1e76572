"""The catalogue of examples that users copy into their packages. The examples' files are in examples/.

An example's folder has a subfolder for each API, ``node`` (`pyros1.Node`) and ``rospy``, and a subfolder ``both`` for
files that are the same for both. In all files, the package is called `PACKAGE_PLACEHOLDER`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from pyros1.ground.errors import Error
from pyros1.ground.suggest import did_you_mean

EXAMPLES_FOLDER = Path(__file__).parent / "examples"
APIS = ("node", "rospy")
"""The APIs: ``node`` is `pyros1.Node`; ``rospy`` is for programs that must also run on other ROS 1 installations."""
SHARED_FOLDER_NAME = "both"
PACKAGE_PLACEHOLDER = "my_package"
"""The package's name in the examples' files; it is replaced when the files are copied."""
_PYTHON_PREFIX = "python3 "


class ExampleError(Error):
    """An example does not exist, or is not available for an API."""


class Example(NamedTuple):
    """An example: small programs that show one feature, with the files that they need.

    Attributes:
        name: the example's name in commands.
        about: a one-line description of what the example consists of.
        depends: the packages that the example needs whatever the API.
        commands: the commands to try the example out, without ``pyros1 ``, and with `PACKAGE_PLACEHOLDER` as the
            package. A line that starts with ``python3`` is a complete command.
        rospy_depends: the packages that the rospy version also needs, in addition to rospy.
    """

    name: str
    about: str
    depends: tuple[str, ...]
    commands: tuple[str, ...]
    rospy_depends: tuple[str, ...] = ()

    @property
    def apis(self) -> tuple[str, ...]:
        """The APIs for which the example is available."""
        return tuple(api for api in APIS if (EXAMPLES_FOLDER / self.name / api).is_dir())

    def files(self, api: str, package: str) -> dict[str, str]:
        """Return the example's files: path in the package -> content.

        Args:
            api: one of `apis`.
            package: the name of the package that the files are for.
        """
        contents = {}
        for part in (SHARED_FOLDER_NAME, api):
            folder = EXAMPLES_FOLDER / self.name / part
            for base, folders, names in os.walk(folder):
                folders[:] = sorted(set(folders) - {"__pycache__"})
                for name in sorted(names):
                    path = Path(base, name)
                    text = path.read_text(encoding="utf-8").replace(PACKAGE_PLACEHOLDER, package)
                    contents[path.relative_to(folder).as_posix().replace(PACKAGE_PLACEHOLDER, package)] = text
        return contents

    def dependencies(self, api: str) -> list[str]:
        """Return the packages on which the example depends with the given API."""
        return [*self.depends, *(["rospy", *self.rospy_depends] if api == "rospy" else [])]


CATALOGUE = (
    Example(
        "publisher", "a node that publishes messages at a fixed rate", ("std_msgs",),
        ("run my_package publisher.py", "topic echo numbers"),
    ),
    Example(
        "subscriber", "a node that receives messages, and keeps its state in a class", ("std_msgs",),
        ("run my_package subscriber.py", "topic pub -r 2 numbers std_msgs/Float64 1.5"),
    ),
    Example(
        "service", "a service with its own type, which can reject requests, and a client that calls the service", (),
        ("run my_package divide_server.py", "run my_package divide_client.py 7 2"),
    ),
    Example(
        "timer", "a node that calls one function periodically, and another once after a delay", ("std_msgs",),
        ("run my_package blinker.py",),
    ),
    Example(
        "parameters", "a node that reads parameters, also from a file, and reacts to changes", ("geometry_msgs",),
        ("launch my_package speed_limiter.launch", "param set /speed_limiter/limits/linear 0.2"),
    ),
    Example(
        "action", "an action with its own type, feedback and cancellation, and a client for it", ("actionlib_msgs",),
        ("run my_package count_server.py", "run my_package count_client.py 20"), ("actionlib",),
    ),
    Example(
        "reconfigure", "a node whose settings can be changed with tools while it is running", ("std_msgs",),
        ("run my_package oscillator.py", "dynparam set oscillator amplitude 2.5"), ("dynamic_reconfigure",),
    ),
    Example(
        "tf_broadcaster", "a node that publishes a moving and a static coordinate frame", ("geometry_msgs",),
        ("run my_package tf_broadcaster.py", "tf tree"), ("tf2_ros",),
    ),
    Example(
        "tf_listener", "a node that looks up the position of one coordinate frame relative to another", (),
        ("run my_package tf_listener.py world laser", "tf static_transform_publisher 1 0 0.5 0 0 0 world laser"),
        ("tf2_ros",),
    ),
    Example(
        "urdf", "a robot description with links and joints, and a node that moves the robot",
        ("joint_state_publisher", "robot_state_publisher", "sensor_msgs"),
        ("launch my_package arm.launch", "web scene --open"),
    ),
    Example(
        "image", "a node that finds edges in images with numpy, and a source of images", ("sensor_msgs",),
        ("run my_package picture_source.py", "run my_package edges.py", "web image --open"),
    ),
    Example(
        "cloud", "a node that filters point clouds with numpy, and a source of point clouds", ("sensor_msgs",),
        ("run my_package cloud_source.py", "run my_package cloud_filter.py", "topic hz filtered"),
    ),
    Example(
        "bag", "a program that writes a bag, and one that analyses a bag with pandas", ("nav_msgs",),
        ("run my_package write_bag.py drive.bag", "run my_package analyse_bag.py drive.bag"), ("rosbag",),
    ),
    Example(
        "asyncio", "an asyncio program that subscribes, publishes and provides a service", ("std_msgs", "std_srvs"),
        ("run my_package averager.py", "topic pub -r 5 numbers std_msgs/Float64 1.5"),
    ),
    Example(
        "test", "a node with tests for pytest and for pyros1 test", ("rostest", "std_msgs"),
        ("test my_package doubler.test", "python3 -m pytest my_package/tests"),
    ),
    Example(
        "launch", "a launch file with all the usual elements, which starts two nodes", ("std_msgs",),
        ("launch my_package robot.launch", "launch my_package robot.launch robot:=r2 rate:=5"),
    ),
)  # fmt: skip


def find_example(name: str, api: str = APIS[0]) -> Example:
    """Return the example with the given name.

    Args:
        name: the example's name.
        api: the API for which the example is needed.

    Raises:
        ExampleError: the example does not exist, or is not available for the API; the message lists what is available.
    """
    examples_by_name = {example.name: example for example in CATALOGUE}
    if name not in examples_by_name:
        hint = did_you_mean(name, examples_by_name)
        raise ExampleError(f"there is no example '{name}'{hint}; the examples are: {', '.join(examples_by_name)}")
    example = examples_by_name[name]
    if api not in example.apis:
        raise ExampleError(
            f"the example '{name}' is not available with --face {api}, only with: {', '.join(example.apis)}"
        )
    return example


def is_build_dependency(package: str) -> bool:
    """Return whether stock ROS needs a package's dependency when the package is built, for messages or CMake functions.

    Other dependencies are only needed at run time.
    """
    return package.endswith(("_msgs", "_srvs")) or package in ("dynamic_reconfigure", "rospy")


def collect_files(examples: Sequence[Example], api: str, package: str) -> dict[str, str]:
    """Return the files of several examples, and a README.md that lists the examples: path -> content.

    Args:
        examples: the examples.
        api: an API for which all the examples are available.
        package: the name of the package that the files are for.
    """
    files: dict[str, str] = {}
    for example in examples:
        files.update(example.files(api, package))
    return {"README.md": _readme(examples, package), **files}


def commands_to_try(examples: Sequence[Example], package: str) -> list[str]:
    """Return the command lines for trying out examples in a package."""
    lines = [line.replace(PACKAGE_PLACEHOLDER, package) for example in examples for line in example.commands]
    return [line if line.startswith(_PYTHON_PREFIX) else f"pyros1 {line}" for line in lines]


def _readme(examples: Sequence[Example], package: str) -> str:
    lines = [f"# {package}", ""]
    for example in examples:
        lines += [
            f"{example.name}: {example.about}.",
            "",
            *(f"    {line}" for line in commands_to_try([example], package)),
            "",
        ]
    lines += [
        "Nothing needs to be built: pyros1 finds the package from its parent folder and from inside the package. Each",
        "program explains at the top what it does and how to run it.",
        "",
    ]
    return "\n".join(lines)
