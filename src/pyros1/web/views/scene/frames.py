"""Shows all frames in a 3D scene."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.web.server.wire import Push
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MAX_FRAMES = 2_000
_MAX_TREES = 10
_DEFAULT_FRAME = "map"
"""The fixed frame while there are no frames."""


class SceneFramesView(View):
    """The poses of all frames, relative to one of them.

    Args (sent by the page):
        fixed: the frame in which poses are expressed; empty for the root of a tree, or ``map``.
        robot: if no fixed frame is given, the root of this frame's tree is used; if it is in no tree, that of the
            largest tree.

    Pushes ``{"fixed": NAME, "names": [...], "parents": [...], "lost": [...], "trees": [[ROOT, COUNT], ...]}`` with
    seven float64 for each name: x, y, z in metres, and a quaternion x, y, z, w. "lost" are frames that are not
    connected to the fixed frame. "trees" are the largest trees, with their numbers of frames.
    """

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        self.change(args)
        self._unwatch = robot.tf_listener.watch(wake)

    def poll(self) -> Push | None:
        tf_listener = self.robot.tf_listener
        states = tf_listener.buffer.states()[:_MAX_FRAMES]
        parents = {state.name: state.parent or "" for state in states}
        roots = find_roots(parents)
        sizes = Counter(roots.values())
        fixed = self._fixed_frame or roots.get(self._robot) or max(sizes, key=sizes.__getitem__, default=_DEFAULT_FRAME)
        names, unplaced, numbers = [], [], array("d")
        for name in parents:
            pose = tf_listener.pose(fixed, name)
            if pose is None:
                unplaced.append(name)
            else:
                names.append(name)
                numbers.extend(pose)
        description = {
            "fixed": fixed,
            "names": names,
            "parents": [parents[name] for name in names],
            "lost": unplaced,
            "trees": sizes.most_common(_MAX_TREES),
        }
        return Push(description, numbers.tobytes())

    def change(self, args: Mapping[str, Any]) -> None:
        self._fixed_frame = string_arg(args, "fixed", "").lstrip("/")
        self._robot = string_arg(args, "robot", "").lstrip("/")

    def close(self) -> None:
        self._unwatch()


def find_roots(parents: Mapping[str, str]) -> dict[str, str]:
    """Return frame -> root of the frame's tree. Frames whose ancestors form a loop have no root, and are omitted.

    Args:
        parents: frame -> its parent; the parent of a root is empty.
    """
    roots: dict[str, str] = {}
    for name in parents:
        ancestor, path = name, dict[str, None]()
        while ancestor not in roots and ancestor not in path and parents.get(ancestor):
            path[ancestor] = None
            ancestor = parents[ancestor]
        root = roots.get(ancestor, "" if ancestor in path else ancestor)
        roots.update(dict.fromkeys([*path, ancestor], root))
    return {name: root for name, root in roots.items() if root}
