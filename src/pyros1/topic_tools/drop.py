"""drop: leaves out the first X of every Y messages (https://wiki.ros.org/topic_tools/drop)."""

from __future__ import annotations

from itertools import cycle

from pyros1.msgs import AnyMsg


class Drop:
    """A gate for `Relay`.

    Args:
        dropped: number of messages to drop, X.
        among: size of each group of messages, Y.
    """

    def __init__(self, dropped: int, among: int) -> None:
        self._passes = cycle([number >= dropped for number in range(among)])

    def __call__(self, message: AnyMsg) -> bool:
        """Return whether the message passes."""
        return next(self._passes)
