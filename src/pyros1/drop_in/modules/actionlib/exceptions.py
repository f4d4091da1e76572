"""The exception of actionlib."""


class ActionException(Exception):
    """A type is not an action."""
