"""Describes which fields of exchanged types only one side has. No I/O."""

from __future__ import annotations

from collections.abc import Iterator

from pyros1.ros2.bridge.plan import Plan
from pyros1.ros2.bridge.service_plan import ServicePlan
from pyros1.ros2_types.transcoding.transcoder import Transcoder

MAX_TYPES = 5_000
"""Maximum number of type pairs that are remembered as reported."""
_MAX_FIELDS = 8


def difference(ros1: str, ros2: str, transcoder: Transcoder) -> str:
    """Return a line with the fields that only one of two types has; empty if there are none.

    Args:
        ros1, ros2: the names of the types.
        transcoder: converts between them.
    """
    parts = []
    if transcoder.only_ros1:
        parts.append(f"only ROS 1 has {_listed(transcoder.only_ros1)}")
    if transcoder.only_ros2:
        parts.append(f"only ROS 2 has {_listed(transcoder.only_ros2)}")
    if not parts:
        return ""
    return f"{ros1} is {ros2}, but {', '.join(parts)}: left out on the way there, zero or empty on the way back"


class Differences:
    """Describes the differences of each pair of types once. Not thread-safe."""

    def __init__(self) -> None:
        self._said: dict[tuple[str, str, Transcoder], None] = {}

    def new(self, plan: Plan, services: ServicePlan) -> Iterator[str]:
        """Yield the lines about types in plans that have not been yielded before."""
        pairs = [announced.pair for announced in plan.announces.values()]
        pairs += [pair for taken in plan.takes.values() for pair, _ in taken.keys.values()]
        found = [(pair.ros1, pair.ros2, pair.transcoder) for pair in pairs]
        service_pairs = [offered.pair for offered in services.offers.values()]
        service_pairs += [provided.pair for provided in services.provides.values()]
        for service in service_pairs:
            found.append((f"{service.ros1}Request", f"{service.ros2}_Request", service.request))
            found.append((f"{service.ros1}Response", f"{service.ros2}_Response", service.response))
        for key in found:
            if key in self._said:
                continue
            if len(self._said) >= MAX_TYPES:
                del self._said[next(iter(self._said))]
            self._said[key] = None
            if line := difference(*key):
                yield line


def _listed(names: list[str]) -> str:
    more = len(names) - _MAX_FIELDS
    return ", ".join(names[:_MAX_FIELDS]) + (f" and {more} more" if more > 0 else "")
