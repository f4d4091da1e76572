"""The node's copies of parameters."""

from __future__ import annotations

from typing import Any

from pyros1.drop_in.missing import names as _names
from pyros1.drop_in.process import PROCESS

SEP = GLOBALNS = "/"


class ParamServerCache:
    """Copies of parameters that the master keeps up to date; `rospy.get_param_cached` makes them."""

    def get(self, key: str) -> Any:
        """Return the copy of a parameter.

        Raises:
            KeyError: there is none.
        """
        node = PROCESS.node
        if node is None or node.resolve(key) not in node.params.cached_names():
            raise KeyError(key)
        missing = object()
        value = node.params.cached(key, missing)
        if value is missing:
            raise KeyError(key)
        return value

    def delete(self, key: str) -> None:
        """Drop the copy of a parameter.

        Raises:
            KeyError: there is none.
        """
        node = PROCESS.node
        if node is None or node.resolve(key) not in node.params.cached_names():
            raise KeyError(key)
        node.params.uncache(key)

    def update(self, key: str, value: Any) -> None:
        """Take a change of a parameter.

        Raises:
            KeyError: there is no copy.
        """
        node = PROCESS.node
        if node is None or not node.params.update(node.resolve(key), value):
            raise KeyError(key)


_CACHE = ParamServerCache()


def get_param_server_cache() -> ParamServerCache:
    """Return the node's copies of parameters."""
    return _CACHE


__getattr__, __dir__ = _names(__name__)
