"""``tf static_transform_publisher``: publishes a transform that does not change (L197).

With a period, as in tf's program, the transform is published repeatedly on /tf. Without a period, as in tf2_ros's
program, it is published once on /tf_static, which is more efficient.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NoReturn

from pyros1.cli.commands.tf._node import open_node
from pyros1.cli.failures import CommandError, UsageError, report_error
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_unparsed
from pyros1.cli.records import Argument, Flag, Verb

if TYPE_CHECKING:
    from pyros1.node import Node

_PROGRAM = "static_transform_publisher"
_TF_USAGE = """Usage: static_transform_publisher x y z yaw pitch roll frame_id child_frame_id period(milliseconds)
   or: static_transform_publisher x y z qx qy qz qw frame_id child_frame_id period(milliseconds)
Publishes the pose of child_frame_id in frame_id on /tf, once per period."""
_TF2_USAGE = """Usage: static_transform_publisher x y z yaw pitch roll frame_id child_frame_id
   or: static_transform_publisher x y z qx qy qz qw frame_id child_frame_id
   or: static_transform_publisher /param_name
Publishes the pose of child_frame_id in frame_id on /tf_static, once; later subscribers receive it as well."""
_ABOUT_TEXT = (
    "\nUnits are metres and radians. Without a period, the transform is published on /tf_static, which is recommended."
    "\nWith a period, it is published on /tf."
)

_USAGE_EXIT_CODE = 255
_LENGTH_TOLERANCE = 1e-6


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Publish until the node is shut down. Return 255 for a wrong number of arguments, 1 for invalid values.

    With ``--tf`` or ``--tf2`` as the first argument, only the arguments of that package's program are accepted.
    """
    args = list(args)
    package_flag = args.pop(0) if args[:1] in (["--tf"], ["--tf2"]) else ""
    if args[:1] in (["-h"], ["--help"]):
        examples = VERB.examples_text(invocation.program, as_stock=False)
        print(*_usage_texts(package_flag), _ABOUT_TEXT, examples, sep="\n", end="")
        return 0
    if args and args[0].startswith("--"):  # this cannot be the name of a parameter
        raise UsageError(f"no such option: {args[0]}")
    if not _is_valid_count(len(args), package_flag):
        report_error(f"{_PROGRAM} exited due to not having the right number of arguments", _USAGE_EXIT_CODE)
        print(*_usage_texts(package_flag), sep="\n\n")
        return _USAGE_EXIT_CODE
    if len(args) == 1:
        return _publish_parameter(invocation, args[0])
    has_period = package_flag == "--tf" or (
        not package_flag and len(args) > 8 and (len(args) == 10 or not _is_number(args[6]))
    )
    period = _parse_number(args.pop(), "period") / 1000.0 if has_period else None
    *numbers, parent, child = args
    names = ["x", "y", "z", *(["yaw", "pitch", "roll"] if len(numbers) == 6 else ["qx", "qy", "qz", "qw"])]
    values = [_parse_number(text, name) for text, name in zip(numbers, names, strict=True)]
    _check_frames(parent, child)
    if period is not None and period < 0:
        raise CommandError(f"the period must not be negative: {period * 1000:g} ms")
    rotation = _quaternion_from_angles(*values[3:]) if len(values) == 6 else values[3:]
    return _publish_transform(invocation, parent, child, values[:3], rotation, period)


VERB = Verb(
    _PROGRAM,
    "publish a transform that does not change",
    Flag("--tf", hidden=True),
    Flag("--tf2", hidden=True),
    *map(Argument, ("x", "y", "z", "yaw", "pitch", "roll")),
    Argument("frame_id", "frame"),
    Argument("child_frame_id", "frame"),
    Argument("period", optional=True),
    usage="x y z yaw pitch roll frame_id child_frame_id [period]",
    examples=[
        ("1 0 0.5 0 0 0 base_link lidar", "1 m in front and 0.5 m above, without rotation"),
        ("0 0 0 1.5708 0 0 base_link camera", "rotated to the left by 90 degrees (yaw pitch roll)"),
        ("0 0 0 0 0 0.7071 0.7071 base_link camera", "the same rotation as a quaternion (x y z w)"),
        ("1 0 0.5 0 0 0 base_link lidar 100", "publish on /tf every 100 ms"),
        ("/lidar_pose", "publish the geometry_msgs/TransformStamped in a parameter"),
    ],
    aliases=["static"],
    stock="rosrun tf static_transform_publisher",
    parse=leave_unparsed,
    run=run,
)


def _usage_texts(package_flag: str) -> list[str]:
    return {"--tf": [_TF_USAGE], "--tf2": [_TF2_USAGE]}.get(package_flag, [_TF2_USAGE, _TF_USAGE])


def _is_valid_count(count: int, package_flag: str) -> bool:
    return count in {"--tf": (9, 10), "--tf2": (1, 8, 9)}.get(package_flag, (1, 8, 9, 10))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _parse_number(text: str, name: str) -> float:
    if _is_number(text) and math.isfinite(float(text)):
        return float(text)
    raise CommandError(
        f"{name} must be a number, not {text!r}; the order is x y z yaw pitch roll (or qx qy qz qw) frame_id "
        f"child_frame_id [period in ms]"
    )


def _check_frames(parent: str, child: str) -> None:
    if not parent.strip("/") or not child.strip("/"):
        raise CommandError("frame_id and child_frame_id must not be empty")
    if parent == child:
        raise CommandError(f"target_frame and source frame are the same ({parent}, {child}) this cannot work")


def _quaternion_from_angles(yaw: float, pitch: float, roll: float) -> list[float]:
    from pyros1.tf.rotation import from_angles  # noqa: PLC0415 - not needed for quaternions

    return list(from_angles(roll, pitch, yaw))


def _publish_transform(
    invocation: Invocation, parent: str, child: str, position: list[float], rotation: list[float], period: float | None
) -> int:
    rotation, warning = _normalize(rotation)
    with open_node(invocation, _PROGRAM, is_tool=False) as node:
        if warning:
            node.log.warn("%s", warning)
        transform = _make_transform(parent, child, position, rotation)
        if period is None:
            _publish_static(node, transform)
        else:
            _publish_repeatedly(node, transform, period)
    return 0


def _normalize(rotation: list[float]) -> tuple[list[float], str]:
    """Return the quaternion normalized to length 1, and a warning if it had another length.

    Raises:
        CommandError: the quaternion is 0.
    """
    length = math.hypot(*rotation)
    if length < _LENGTH_TOLERANCE:
        raise CommandError("0 0 0 0 is not a valid quaternion; use 0 0 0 1 for no rotation (the order is qx qy qz qw)")
    if abs(length - 1.0) < _LENGTH_TOLERANCE:
        return rotation, ""
    normalized_rotation = [component / length for component in rotation]  # listeners ignore other quaternions
    return normalized_rotation, f"the quaternion's length is {length:g}, not 1: it is normalized"


def _publish_parameter(invocation: Invocation, name: str) -> int:
    with open_node(invocation, _PROGRAM, is_tool=False) as node:
        node.log.info("Looking for TF in parameter: %s", name)
        value = node.params.get(name, None)
        if value is None:
            node.log.fatal("Could not read TF from parameter server: %s", name)
            return _USAGE_EXIT_CODE
        try:
            parent, child = str(value["header"]["frame_id"]), str(value["child_frame_id"])
            position = [float(value["transform"]["translation"][axis]) for axis in "xyz"]
            rotation = [float(value["transform"]["rotation"][axis]) for axis in "xyzw"]
        except (KeyError, TypeError, ValueError) as error:
            _raise_parameter_error(name, error)
        _check_frames(parent, child)
        rotation, warning = _normalize(rotation)
        if warning:
            node.log.warn("%s", warning)
        _publish_static(node, _make_transform(parent, child, position, rotation))
    return 0


def _raise_parameter_error(name: str, error: Exception) -> NoReturn:
    raise CommandError(
        f"the parameter {name} must be a transform like {{header: {{frame_id: base}}, child_frame_id: lidar, "
        f"transform: {{translation: {{x: 0.0, y: 0.0, z: 0.0}}, rotation: {{x: 0.0, y: 0.0, z: 0.0, w: 1.0}}}}}}; "
        f"this one is not: {type(error).__name__}: {error}"
    )


def _make_transform(parent: str, child: str, position: list[float], rotation: list[float]) -> Any:
    from pyros1.msgs import load_message  # noqa: PLC0415 - not needed for invalid arguments

    message: Any = load_message("geometry_msgs/TransformStamped")()
    message.header.frame_id = parent
    message.child_frame_id = child
    translation_field, rotation_field = message.transform.translation, message.transform.rotation
    translation_field.x, translation_field.y, translation_field.z = position
    rotation_field.x, rotation_field.y, rotation_field.z, rotation_field.w = rotation
    return message


def _publish_static(node: Node, transform: Any) -> None:
    from pyros1.tf.broadcaster import StaticTransformBroadcaster  # noqa: PLC0415

    transform.header.stamp = node.now()
    StaticTransformBroadcaster(node).send_transform(transform)
    node.log.info("Spinning until killed publishing %s to %s", transform.header.frame_id, transform.child_frame_id)
    node.spin()


def _publish_repeatedly(node: Node, transform: Any, period: float) -> None:
    """Publish the transform once per period, stamped one period ahead, so that it is valid until the next message."""
    from pyros1.ground.timing import Duration  # noqa: PLC0415
    from pyros1.tf.broadcaster import TransformBroadcaster  # noqa: PLC0415

    broadcaster = TransformBroadcaster(node)
    stamp_offset = Duration.from_sec(period)
    rate = node.rate(1.0 / max(period, 0.001))
    while node.ok():
        transform.header.stamp = node.now() + stamp_offset
        broadcaster.send_transform(transform)
        rate.sleep()
