"""Exceptions of rospy (https://wiki.ros.org/rospy/Overview/Exceptions)."""


class ROSException(Exception):
    """Base of exceptions for programs."""


class ROSSerializationException(ROSException):
    """A message cannot be encoded."""


class ROSInitException(ROSException):
    """The node has not been started."""


class ROSInterruptException(ROSException, KeyboardInterrupt):
    """A wait ended because the node is shutting down."""


class ROSTimeMovedBackwardsException(ROSInterruptException):
    """Simulated time jumped back during a sleep.

    Attributes:
        time: the jump.
    """

    def __init__(self, time: object) -> None:
        self.time = time
        super().__init__("ROS time moved backwards")


class ROSInternalException(Exception):
    """Base of exceptions inside rospy."""


class TransportException(ROSInternalException):
    """Base of transport errors."""


class TransportTerminated(TransportException):
    """A connection has ended."""


class TransportInitError(TransportException):
    """A connection cannot be made."""
