"""Shows a node's dynamic_reconfigure parameters, as they change (https://wiki.ros.org/dynamic_reconfigure)."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.reconfigure.encoding import decode
from pyros1.reconfigure.values import parse_choices
from pyros1.web.hub import Arrival
from pyros1.web.server.wire import Push, RequestError
from pyros1.web.views.view import View, string_arg

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MAX_CHOICES = 200
_MAX_GROUP_DEPTH = 8
"""Maximum nesting depth of groups."""
_MAX_CHOICES_LENGTH = 100_000
"""Maximum number of characters in a list of choices."""


class ReconfigureView(View):
    """A node's dynamic_reconfigure parameters, and their values.

    Args (sent by the page):
        node: the node's name, or the namespace of its parameters.

    Pushes ``{"parameters": [{"name", "type", "groups", "description", "min", "max", "default", "choices"}, ...],
    "values": {name: value}, "groups": [{"path", "type", "name", "state", "id", "parent"}, ...]}``. A parameter's
    "groups" are the names of the groups that contain it, from the outermost to the innermost, without the root group; a
    group's "path" is the same, with its own name at the end. "choices" are a list of names and values. A group of the
    type collapse is closed, and one of the type hide is hidden, while its state is false.
    """

    period = 1 / 15

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        super().__init__(robot, args, wake)
        name = string_arg(args, "node")
        self._lock = threading.Lock()
        self._description: Arrival | None = None
        self._config: Arrival | None = None
        self._unsubscribers: list[Callable[[], None]] = []
        try:
            self._unsubscribers.append(robot.listen(f"{name}/parameter_descriptions", self._on_description))
            self._unsubscribers.append(robot.listen(f"{name}/parameter_updates", self._on_config))
        except RequestError:
            self.close()
            raise

    def poll(self) -> Push | None:
        with self._lock:
            description, config = self._description, self._config
        if description is None or config is None:
            return None
        try:
            return Push(
                {
                    "parameters": parameters(description.checked_message),
                    "values": values(config.checked_message),
                    "groups": groups(description.checked_message, config.checked_message),
                }
            )
        except (MessageError, AttributeError, TypeError) as error:  # the topics have other types
            raise RequestError(f"this is not a dynamic_reconfigure server: {error}") from None

    def close(self) -> None:
        for unsubscribe in self._unsubscribers:
            unsubscribe()

    def _on_description(self, arrival: Arrival) -> None:
        with self._lock:
            self._description = arrival
        self.wake()

    def _on_config(self, arrival: Arrival) -> None:
        with self._lock:
            self._config = arrival
        self.wake()


def parameters(description: Any) -> list[dict[str, Any]]:
    """Return the parameters in a dynamic_reconfigure/ConfigDescription for a page; see `ReconfigureView`."""
    paths = _group_paths(description.groups)
    minimums, maximums, defaults = values(description.min), values(description.max), values(description.dflt)
    return [
        {
            "name": parameter.name,
            "type": parameter.type,
            "groups": paths[group.id],
            "description": parameter.description,
            "min": minimums.get(parameter.name),
            "max": maximums.get(parameter.name),
            "default": defaults.get(parameter.name),
            "choices": _choices(parameter.edit_method),
        }
        for group in description.groups
        for parameter in group.parameters
    ]


def groups(description: Any, config: Any) -> list[dict[str, Any]]:
    """Return the groups with their states for a page; see `ReconfigureView`. A state missing in the config is true.

    Args:
        description: a dynamic_reconfigure/ConfigDescription.
        config: a dynamic_reconfigure/Config.
    """
    paths = _group_paths(description.groups)
    states = {group.id: group.state for group in config.groups}
    return [
        {
            "path": paths[each.id],
            "type": each.type,
            "name": each.name,
            "state": states.get(each.id, True),
            "id": each.id,
            "parent": each.parent,
        }
        for each in description.groups
    ]


def _group_paths(groups: Any) -> dict[int, list[str]]:
    """Return group id -> path of the group. Parents may be missing or circular."""
    group_by_id = {group.id: group for group in groups}
    paths: dict[int, list[str]] = {}
    for group in groups:
        path: list[str] = []
        ancestor, visited = group, set()
        while ancestor is not None and ancestor.id != 0 and ancestor.id not in visited and len(path) < _MAX_GROUP_DEPTH:
            visited.add(ancestor.id)
            path.insert(0, ancestor.name)
            ancestor = group_by_id.get(ancestor.parent)
        paths[group.id] = path
    return paths


def values(config: Any) -> dict[str, Any]:
    """Return the values in a dynamic_reconfigure/Config as JSON, with null for non-finite numbers."""
    return {name: _to_json(value) for name, value in decode(config, dict).items()}


def _choices(edit_method: str) -> list[list[Any]]:
    if len(edit_method) > _MAX_CHOICES_LENGTH:
        return []
    all_choices = parse_choices(edit_method)
    return [[name, _to_json(value)] for name, value in list(all_choices.items())[:_MAX_CHOICES]]


def _to_json(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
