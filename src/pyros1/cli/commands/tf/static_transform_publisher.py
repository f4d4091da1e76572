"""``tf static_transform_publisher``: a transform that does not change (L197).

With a period, as in the program of tf, it is published repeatedly on /tf. Without, as in the program of tf2_ros, it is
published once on /tf_static, which costs less.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NoReturn

from pyros1.cli.commands.tf._node import open_node
from pyros1.cli.failures import CommandError, UsageError, report
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import leave_words
from pyros1.cli.records import Argument, Flag, Verb

if TYPE_CHECKING:
    from pyros1.node import Node

_NAME = "static_transform_publisher"
_TF_USAGE = """Usage: static_transform_publisher x y z yaw pitch roll frame_id child_frame_id period(milliseconds)
   or: static_transform_publisher x y z qx qy qz qw frame_id child_frame_id period(milliseconds)
Publishes the pose of child_frame_id in frame_id on /tf, once per period."""
_TF2_USAGE = """Usage: static_transform_publisher x y z yaw pitch roll frame_id child_frame_id
   or: static_transform_publisher x y z qx qy qz qw frame_id child_frame_id
   or: static_transform_publisher /param_name
Publishes the pose of child_frame_id in frame_id on /tf_static, once; later subscribers receive it, too."""
_ABOUT = "\nUnits are metres and radians. Without a period it publishes on /tf_static (recommended), with one on /tf."

_WRONG = 255
_UNIT = 1e-6


def run(invocation: Invocation, options: Any, args: list[str]) -> int:
    """Run the node until it is told to end. Return 255 for a wrong number of arguments, 1 for wrong values.

    The flags ``--tf`` and ``--tf2``, as the first argument, allow only the forms of that package's program.
    """
    words = list(args)
    forms = words.pop(0) if words[:1] in (["--tf"], ["--tf2"]) else ""
    if words[:1] in (["-h"], ["--help"]):
        examples = VERB.examples_text(invocation.program, as_stock=False)
        print(*_usages(forms), _ABOUT, examples, sep="\n", end="")
        return 0
    if words and words[0].startswith("--"):  # not the name of a parameter to wait for
        raise UsageError(f"no such option: {words[0]}")
    if not _form_fits(len(words), forms):
        report(f"{_NAME} exited due to not having the right number of arguments", _WRONG)
        print(*_usages(forms), sep="\n\n")
        return _WRONG
    if len(words) == 1:
        return _publish_parameter(invocation, words[0])
    with_period = forms == "--tf" or (not forms and len(words) > 8 and (len(words) == 10 or not _is_number(words[6])))
    period = _number(words.pop(), "period") / 1000.0 if with_period else None
    *numbers, parent, child = words
    kinds = ["x", "y", "z", *(["yaw", "pitch", "roll"] if len(numbers) == 6 else ["qx", "qy", "qz", "qw"])]
    values = [_number(text, kind) for text, kind in zip(numbers, kinds, strict=True)]
    _check_frames(parent, child)
    if period is not None and period < 0:
        raise CommandError(f"the period must not be negative: {period * 1000:g} ms")
    rotation = _from_angles(*values[3:]) if len(values) == 6 else values[3:]
    return _publish(invocation, parent, child, values[:3], rotation, period)


VERB = Verb(
    _NAME,
    "publish a transform that does not change",
    Flag("--tf", hidden=True),
    Flag("--tf2", hidden=True),
    *map(Argument, ("x", "y", "z", "yaw", "pitch", "roll")),
    Argument("frame_id", "frame"),
    Argument("child_frame_id", "frame"),
    Argument("period", optional=True),
    usage="x y z yaw pitch roll frame_id child_frame_id [period]",
    examples=[
        ("1 0 0.5 0 0 0 base_link lidar", "1 m in front and 0.5 m above, not turned"),
        ("0 0 0 1.5708 0 0 base_link camera", "turned to the left by 90 degrees (yaw pitch roll)"),
        ("0 0 0 0 0 0.7071 0.7071 base_link camera", "the same as a quaternion (x y z w)"),
        ("1 0 0.5 0 0 0 base_link lidar 100", "on /tf, every 100 ms"),
        ("/lidar_pose", "the transform in a parameter, as geometry_msgs/TransformStamped"),
    ],
    aliases=["static"],
    stock="rosrun tf static_transform_publisher",
    parse=leave_words,
    run=run,
)


def _usages(forms: str) -> list[str]:
    return {"--tf": [_TF_USAGE], "--tf2": [_TF2_USAGE]}.get(forms, [_TF2_USAGE, _TF_USAGE])


def _form_fits(count: int, forms: str) -> bool:
    return count in {"--tf": (9, 10), "--tf2": (1, 8, 9)}.get(forms, (1, 8, 9, 10))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _number(text: str, what: str) -> float:
    if _is_number(text) and math.isfinite(float(text)):
        return float(text)
    raise CommandError(
        f"{what} must be a number, not {text!r}; in this order: x y z yaw pitch roll (or qx qy qz qw) frame_id "
        f"child_frame_id [period in ms]"
    )


def _check_frames(parent: str, child: str) -> None:
    if not parent.strip("/") or not child.strip("/"):
        raise CommandError("frame_id and child_frame_id must not be empty")
    if parent == child:
        raise CommandError(f"target_frame and source frame are the same ({parent}, {child}) this cannot work")


def _from_angles(yaw: float, pitch: float, roll: float) -> list[float]:
    from pyros1.tf.rotation import from_angles  # noqa: PLC0415 - quaternions need no calculation

    return list(from_angles(roll, pitch, yaw))


def _publish(
    invocation: Invocation, parent: str, child: str, position: list[float], rotation: list[float], period: float | None
) -> int:
    rotation, warning = _normalized(rotation)
    with open_node(invocation, _NAME, tool=False) as node:
        if warning:
            node.log.warn("%s", warning)
        transform = _stamped(parent, child, position, rotation)
        if period is None:
            _publish_static(node, transform)
        else:
            _publish_repeatedly(node, transform, period)
    return 0


def _normalized(rotation: list[float]) -> tuple[list[float], str]:
    """Return the quaternion normalized to length 1, and a warning if it was not."""
    length = math.hypot(*rotation)
    if length < _UNIT:
        raise CommandError("0 0 0 0 is not a valid quaternion; use 0 0 0 1 for no rotation (the order is qx qy qz qw)")
    if abs(length - 1.0) < _UNIT:
        return rotation, ""
    # Listeners would ignore it.
    return [part / length for part in rotation], f"the quaternion's length is {length:g}, not 1: it is normalized"


def _publish_parameter(invocation: Invocation, name: str) -> int:
    with open_node(invocation, _NAME, tool=False) as node:
        node.log.info("Looking for TF in parameter: %s", name)
        value = node.params.get(name, None)
        if value is None:
            node.log.fatal("Could not read TF from parameter server: %s", name)
            return _WRONG
        try:
            frame, child = str(value["header"]["frame_id"]), str(value["child_frame_id"])
            position = [float(value["transform"]["translation"][axis]) for axis in "xyz"]
            rotation = [float(value["transform"]["rotation"][axis]) for axis in "xyzw"]
        except (KeyError, TypeError, ValueError) as error:
            _refuse_parameter(name, error)
        _check_frames(frame, child)
        rotation, warning = _normalized(rotation)
        if warning:
            node.log.warn("%s", warning)
        _publish_static(node, _stamped(frame, child, position, rotation))
    return 0


def _refuse_parameter(name: str, error: Exception) -> NoReturn:
    raise CommandError(
        f"the parameter {name} must be a transform like {{header: {{frame_id: base}}, child_frame_id: lidar, "
        f"transform: {{translation: {{x: 0.0, y: 0.0, z: 0.0}}, rotation: {{x: 0.0, y: 0.0, z: 0.0, w: 1.0}}}}}}; "
        f"this one is not: {type(error).__name__}: {error}"
    )


def _stamped(parent: str, child: str, position: list[float], rotation: list[float]) -> Any:
    from pyros1.msgs import load_message  # noqa: PLC0415 - not needed for wrong arguments

    message: Any = load_message("geometry_msgs/TransformStamped")()
    message.header.frame_id = parent
    message.child_frame_id = child
    v, q = message.transform.translation, message.transform.rotation
    v.x, v.y, v.z = position
    q.x, q.y, q.z, q.w = rotation
    return message


def _publish_static(node: Node, transform: Any) -> None:
    from pyros1.tf.broadcaster import StaticTransformBroadcaster  # noqa: PLC0415

    transform.header.stamp = node.now()
    StaticTransformBroadcaster(node).send_transform(transform)
    node.log.info("Spinning until killed publishing %s to %s", transform.header.frame_id, transform.child_frame_id)
    node.spin()


def _publish_repeatedly(node: Node, transform: Any, period: float) -> None:
    """Publish once. The stamp is one period ahead, so that the transform is valid until the next one."""
    from pyros1.ground.timing import Duration  # noqa: PLC0415
    from pyros1.tf.broadcaster import TransformBroadcaster  # noqa: PLC0415

    broadcaster = TransformBroadcaster(node)
    ahead = Duration.from_sec(period)
    rate = node.rate(1.0 / max(period, 0.001))
    while node.ok():
        transform.header.stamp = node.now() + ahead
        broadcaster.send_transform(transform)
        rate.sleep()
