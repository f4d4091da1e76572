"""Exceptions of state machines."""


class SmachError(Exception):
    """Base class of smach's errors."""


class InvalidStateError(SmachError):
    """A state is missing, was added twice, or has invalid arguments."""


class InvalidTransitionError(SmachError):
    """A transition has no target, or an outcome is not one of its state's outcomes."""


class InvalidConstructionError(SmachError):
    """A container was constructed incorrectly."""


class InvalidUserCodeError(SmachError):
    """A state or a callback of the program failed, or used a key that it did not declare."""


__all__ = [
    "InvalidConstructionError",
    "InvalidStateError",
    "InvalidTransitionError",
    "InvalidUserCodeError",
    "SmachError",
]
