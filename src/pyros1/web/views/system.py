"""Shows the ROS system: nodes, topics, services and connections."""

from __future__ import annotations

from typing import Any

from pyros1.web.server.wire import Push
from pyros1.web.views.view import View

_MAX_NODES = 100
"""Number of nodes above which the nodes are queried less often."""


class SystemView(View):
    """Pushes the result of `pyros1.web.system.System.describe`, once a second, if it has changed."""

    period = 1.0
    polls_periodically = True

    _last_pushed: Any = None

    def poll(self) -> Push | None:
        _ = self.robot.node
        description = self.robot.system.describe(max_age=self.period * 0.8)
        self.period = 1.0 if len(description["nodes"]) <= _MAX_NODES else 4.0
        if description is self._last_pushed:
            return None
        self._last_pushed = description
        return Push(self._visible_part(description))

    def _visible_part(self, description: dict[str, Any]) -> dict[str, Any]:
        access = self.robot.access
        if not access.topics:
            return {**description, "master": self.robot.master_uri}
        may_see = access.may_see
        return {
            **description,
            "master": self.robot.master_uri,
            "topics": {name: topic for name, topic in description["topics"].items() if may_see(name)},
            "services": {name: nodes for name, nodes in description["services"].items() if may_see(name)},
            "bridges": [
                {**bridge, "flows": [flow for flow in bridge["flows"] if may_see(flow["topic"])]}
                for bridge in description["bridges"]
            ],
            "edges": [edge for edge in description["edges"] if may_see(edge[0])],
            "missing": [edge for edge in description["missing"] if may_see(edge[0])],
        }
