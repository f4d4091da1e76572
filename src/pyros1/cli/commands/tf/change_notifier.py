"""``tf change_notifier``: publishes on /tf_changes when one frame has moved relative to another (L199)."""

from __future__ import annotations

import math
import time
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Verb
from pyros1.ground.errors import TimeMovedBackwardsError

if TYPE_CHECKING:
    from pyros1.node import Node

_MESSAGE_TYPE = "tf/tfMessage"
_DEFAULT_DISTANCE = 0.1
_DEFAULT_ANGLE = 0.1
_DEFAULT_FREQUENCY = 10.0
_USAGE = """[_polling_frequency:=HZ] [_translational_update_distance:=METRES]
       [_angular_update_distance:=RADIANS]

Watches the pose of a frame relative to another frame, by default of base_link relative to map. The pose is checked HZ
times per second (default 10). It is published on the latched topic tf_changes when, since it was last published, the
frame has moved by more than METRES (default 0.1) or turned by more than twice RADIANS (default 0.1).

To watch other frames, set the parameter ~frame_pairs to a list of {source_frame: NAME, target_frame: NAME}. The pose of
source_frame relative to target_frame is watched. An item of the list can also contain translational_update_distance and
angular_update_distance, which are used for this item instead of METRES and RADIANS."""


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Publish changes until the node is shut down."""
    if args:
        raise UsageError(f"unexpected argument {args[0]!r}: set the parameter ~frame_pairs to the frames")
    from pyros1.node import Node  # noqa: PLC0415 - not needed for help
    from pyros1.tf import Buffer, TransformException, TransformListener  # noqa: PLC0415

    name = f"change_notifier_{time.time_ns()}"
    with Node(name, argv=invocation.remapping_args, environ=invocation.environ) as node:
        frequency = _check_parameter(node.params.get("~polling_frequency", _DEFAULT_FREQUENCY), "~polling_frequency")
        if frequency == 0:
            raise CommandError("the parameter ~polling_frequency must be greater than 0")
        pairs = _read_pairs(node)
        buffer = Buffer()
        TransformListener(node, buffer)
        publisher: Any = node.advertise("tf_changes", _MESSAGE_TYPE, queue_size=1, latch=True)
        while node.ok():
            changes = []
            for pair in pairs:
                try:
                    transform = buffer.lookup_transform(pair.target, pair.source)
                except TransformException as error:
                    node.log.debug("%s", error)
                    continue
                if pair.check_moved(transform.transform):
                    # As in tf, these names begin with a slash.
                    transform.header.frame_id, transform.child_frame_id = f"/{pair.target}", f"/{pair.source}"
                    changes.append(transform)
            if changes:
                publisher.publish(changes)
            with suppress(TimeMovedBackwardsError):
                node.sleep(1 / frequency)


VERB = Verb(
    "change_notifier",
    "publish the pose of a frame on /tf_changes when the frame has moved",
    usage=_USAGE,
    examples=[
        ("", "publish when base_link moves relative to map"),
        ("_frame_pairs:='[{source_frame: arm, target_frame: base_link}]'", "publish when the arm moves"),
    ],
    aliases=["tf_change_notifier"],
    stock="rosrun tf tf_change_notifier",
    run=run,
)


@dataclass
class FramePair:
    """A frame whose pose relative to another is watched.

    Args:
        source: the name of the frame.
        target: the name of the other frame.
        distance: a distance in metres. Moves by more than this distance are published.
        angle: an angle in radians. Rotations by more than twice this angle are published, as in tf.
    """

    source: str
    target: str
    distance: float = _DEFAULT_DISTANCE
    angle: float = _DEFAULT_ANGLE
    _last_transform: Any = None

    def check_moved(self, transform: Any) -> bool:
        """Return whether the frame has moved since the last call that returned True. The first call returns True.

        Args:
            transform: a geometry_msgs/Transform.
        """
        if self._last_transform is None or self._has_changed(transform, self._last_transform):
            self._last_transform = transform
            return True
        return False

    def _has_changed(self, first: Any, second: Any) -> bool:
        a, b, p, q = first.translation, second.translation, first.rotation, second.rotation
        # A quaternion and its negative are the same rotation.
        dot = min(1.0, abs(p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w))
        return math.dist((a.x, a.y, a.z), (b.x, b.y, b.z)) > self.distance or math.acos(dot) > self.angle


def _read_pairs(node: Node) -> list[FramePair]:
    distance = _check_parameter(
        node.params.get("~translational_update_distance", _DEFAULT_DISTANCE), "~translational_update_distance"
    )
    angle = _check_parameter(node.params.get("~angular_update_distance", _DEFAULT_ANGLE), "~angular_update_distance")
    pair_dicts = node.params.get("~frame_pairs")
    if pair_dicts is None:
        return [FramePair("base_link", "map", distance, angle)]
    if not isinstance(pair_dicts, list) or not all(isinstance(entry, dict) for entry in pair_dicts):
        raise CommandError(
            f"the parameter ~frame_pairs must be a list like [{{source_frame: NAME, target_frame: NAME}}], "
            f"not {pair_dicts!r}"
        )
    pairs = [
        FramePair(
            _read_frame(entry, "source_frame"),
            _read_frame(entry, "target_frame"),
            _check_parameter(entry.get("translational_update_distance", distance), "translational_update_distance"),
            _check_parameter(entry.get("angular_update_distance", angle), "angular_update_distance"),
        )
        for entry in pair_dicts
    ]
    for pair in pairs:
        node.log.info(
            "Watching %s in %s: moves of more than %g m, rotations of more than twice %g rad",
            pair.source,
            pair.target,
            pair.distance,
            pair.angle,
        )
    return pairs


def _read_frame(entry: dict[str, Any], key: str) -> str:
    name = entry.get(key)
    if not isinstance(name, str) or not name.strip("/"):
        raise CommandError(f"in ~frame_pairs, {key} must be a frame name, not {name!r}")
    return name.lstrip("/")


def _check_parameter(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value < float("inf"):
        raise CommandError(f"the parameter {name} must be a non-negative number, not {value!r}")
    return float(value)
