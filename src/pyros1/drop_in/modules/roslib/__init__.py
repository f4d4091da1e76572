"""roslib, by pyros1 (https://wiki.ros.org/roslib): most of it has moved to rospkg, rosgraph and genpy."""

from pyros1.drop_in.module_attributes import module_hooks as _module_hooks
from roslib.launcher import load_manifest

__all__ = ["is_interactive", "load_manifest", "set_interactive"]

_is_interactive = False

_LAZY_MODULES = ("exceptions", "launcher", "manifest", "message", "names", "packages")
__getattr__, __dir__ = _module_hooks(__name__, {name: f"{__name__}.{name}." for name in _LAZY_MODULES})


def set_interactive(interactive: bool) -> None:
    """Set whether the program is an interactive shell."""
    global _is_interactive  # noqa: PLW0603
    _is_interactive = interactive


def is_interactive() -> bool:
    """Return the value set by :func:`set_interactive`."""
    return _is_interactive
