"""drop: of every so many messages the first few are left out (https://wiki.ros.org/topic_tools/drop)."""

from __future__ import annotations

from itertools import cycle

from pyros1.msgs import AnyMsg


class Drop:
    """A gate for `Relay`.

    Args:
        dropped: how many are left out,
        among: of how many.
    """

    def __init__(self, dropped: int, among: int) -> None:
        self._passes = cycle([number >= dropped for number in range(among)])

    def __call__(self, message: AnyMsg) -> bool:
        """Say whether the message passes."""
        return next(self._passes)
