"""State shared by all viewers, so that many viewers put no more load on the master than one."""

from __future__ import annotations

import secrets
import threading
from time import monotonic

from pyros1.ground.errors import ParameterNotSetError
from pyros1.web.foxglove.catalogue import Catalogue
from pyros1.web.foxglove.parameters import ParameterValues
from pyros1.web.robot import Robot


class ViewerContext:
    """State shared by all viewers.

    Attributes:
        robot: the robot.
        catalogue: the robot's channels and services.
        files: the files of the robot's packages.
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
        """Return the parameters.

        Args:
            max_age: maximum age in seconds of values that are reused; older values are reused only while another
                thread queries the master. With 0, they are always requested.

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
