"""Reads and changes the log levels of other nodes."""

from __future__ import annotations

from typing import Any


class ROSConsoleException(Exception):
    """Log levels cannot be listed or set."""


class LoggerLevelServiceCaller:
    """Lists and sets the log levels of nodes."""

    def __init__(self) -> None:
        self._levels: dict[str, str] = {}

    def get_levels(self) -> list[str]:
        """Return the names of the levels."""
        return ["debug", "info", "warn", "error", "fatal"]

    def get_loggers(self, node: str) -> list[str]:
        """Return the names of a node's loggers, and remember their levels.

        Raises:
            ROSConsoleException: the node does not respond.
        """
        import rospy
        from pyros1.msgs.roscpp.srv import GetLoggers

        self._levels = {}
        try:
            service = rospy.ServiceProxy(node.rstrip("/") + "/get_loggers", GetLoggers)
            self._levels = {logger.name: logger.level.lower() for logger in service().loggers}
        except rospy.ServiceException as error:
            raise ROSConsoleException(f"unable to get the loggers of {node}: {error}") from error
        return sorted(self._levels)

    def get_node_names(self) -> list[str]:
        """Return the names of the nodes whose log levels can be changed.

        Raises:
            ROSConsoleException: the master does not respond.
        """
        import rospy

        try:
            code, message, state = rospy.get_master().getSystemState()
        except OSError as error:
            raise ROSConsoleException(f"the master does not respond: {error}") from error
        if code != 1:
            raise ROSConsoleException(message)
        suffix = "/set_logger_level"
        services: list[Any] = state[2]
        return sorted(name[: -len(suffix)] for name, _ in services if name.endswith(suffix))

    def send_logger_change_message(self, node: str, logger: str, level: str) -> bool:
        """Set a logger's level; return whether it has changed.

        Raises:
            ROSConsoleException: the node does not respond.
        """
        import rospy
        from pyros1.msgs.roscpp.srv import SetLoggerLevel

        if self._levels.get(logger) == level.lower():
            return False
        try:
            rospy.ServiceProxy(node.rstrip("/") + "/set_logger_level", SetLoggerLevel)(logger, level)
        except rospy.ServiceException as error:
            raise ROSConsoleException(f"unable to set the level of {logger} in {node}: {error}") from error
        self._levels[logger] = level.lower()
        return True
