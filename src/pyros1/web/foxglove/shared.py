"""State shared by all viewers, so that many cost the master no more than one."""

from __future__ import annotations

import secrets
import threading
from time import monotonic

from pyros1.ground.errors import ParameterNotSetError
from pyros1.web.foxglove.catalogue import Catalogue
from pyros1.web.foxglove.parameters import Values
from pyros1.web.robot import Robot


class ViewerContext:
    """State shared by all viewers.

    Attributes:
        robot: the robot that they view.
        catalogue: its channels and services.
        files: the files of its packages.
        session: name of this run of the server.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.catalogue = Catalogue(robot.graph, robot.access.may_see)
        self.files = robot.files
        self.session = secrets.token_hex(8)
        self._lock = threading.Lock()
        self._values = Values({})
        self._fetched_at = float("-inf")

    def parameters(self, max_age: float) -> Values:
        """Return the parameters.

        Args:
            max_age: seconds; younger values are reused, as are the last ones while another thread is asking.
                With 0, they are requested now.

        Raises:
            MasterUnreachableError: the master does not answer.
        """
        if not self._lock.acquire(blocking=max_age <= 0):
            return self._values
        try:
            if monotonic() - self._fetched_at >= max_age:
                try:
                    tree = self.robot.master.get_param("/")
                except ParameterNotSetError:
                    tree = {}
                self._values = Values(tree if isinstance(tree, dict) else {}, self.robot.access.may_see)
                self._fetched_at = monotonic()
            return self._values
        finally:
            self._lock.release()
