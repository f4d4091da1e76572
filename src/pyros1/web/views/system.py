"""Nodes, topics, services and connections."""

from __future__ import annotations

from typing import Any

from pyros1.web.server.wire import Push
from pyros1.web.views.view import View

_MOST_NODES = 100
"""Beyond this number of nodes, they are asked less often."""


class SystemView(View):
    """What `pyros1.web.system.System.describe` returns, once a second, whenever it has changed."""

    period = 1.0
    polled = True

    _shown: Any = None

    def take(self) -> Push | None:
        _ = self.robot.node
        description = self.robot.system.describe(max_age=self.period * 0.8)
        self.period = 1.0 if len(description["nodes"]) <= _MOST_NODES else 4.0
        if description is self._shown:
            return None
        self._shown = description
        return Push(self._visible(description))

    def _visible(self, description: dict[str, Any]) -> dict[str, Any]:
        access = self.robot.access
        if not access.topics:
            return {**description, "master": self.robot.master_uri}
        see = access.may_see
        return {
            **description,
            "master": self.robot.master_uri,
            "topics": {name: facts for name, facts in description["topics"].items() if see(name)},
            "services": {name: nodes for name, nodes in description["services"].items() if see(name)},
            "edges": [edge for edge in description["edges"] if see(edge[0])],
            "missing": [edge for edge in description["missing"] if see(edge[0])],
        }
