"""State that all viewers share, so that many viewers put no more load on the master than a single viewer."""

from __future__ import annotations

import secrets
import threading
from time import monotonic

from pyros1.ground.errors import ParameterNotSetError
from pyros1.web.foxglove.catalogue import Catalogue
from pyros1.web.foxglove.parameters import ParameterValues
from pyros1.web.robot import Robot


class ViewerContext:
    """The state that all viewers of a robot share.

    Attributes:
        robot: the robot.
        catalogue: the robot's channels and services.
        files: the files in ROS packages.
        session: an id that is unique to this run of the server.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.catalogue = Catalogue(robot.graph, robot.access.may_see)
        self.files = robot.files
        self.session = secrets.token_hex(8)
        self._lock = threading.Lock()
        self._values = ParameterValues({})
        self._fetched_at = float("-inf")

    def parameters(self, max_age: float) -> ParameterValues:
        """Return the parameters that viewers may see.

        Args:
            max_age: the latest values are returned if they are not older than this, in seconds; older values are
                returned only while another thread queries the master. With 0, the master is always queried.

        Raises:
            MasterUnreachableError: the master does not respond.
        """
        if not self._lock.acquire(blocking=max_age <= 0):
            return self._values
        try:
            if monotonic() - self._fetched_at >= max_age:
                try:
                    tree = self.robot.master.get_param("/")
                except ParameterNotSetError:
                    tree = {}
                self._values = ParameterValues(tree if isinstance(tree, dict) else {}, self.robot.access.may_see)
                self._fetched_at = monotonic()
            return self._values
        finally:
            self._lock.release()
