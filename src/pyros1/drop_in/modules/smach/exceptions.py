"""What goes wrong in state machines."""


class SmachError(Exception):
    """Base of the errors of smach."""


class InvalidStateError(SmachError):
    """A state is not there, is there twice, or was described wrongly."""


class InvalidTransitionError(SmachError):
    """A transition leads nowhere, or an outcome is not one of its state."""


class InvalidConstructionError(SmachError):
    """A container was built wrongly."""


class InvalidUserCodeError(SmachError):
    """A state or a callback of the program failed, or used a key that it did not declare."""


__all__ = [
    "InvalidConstructionError",
    "InvalidStateError",
    "InvalidTransitionError",
    "InvalidUserCodeError",
    "SmachError",
]
