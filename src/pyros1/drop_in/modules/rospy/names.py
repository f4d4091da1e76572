"""Resolves names, and provides the node's own name (https://wiki.ros.org/Names)."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable
from typing import Any

from pyros1.drop_in.module_attributes import module_hooks as _module_hooks
from pyros1.drop_in.process import PROCESS
from pyros1.ground import names
from pyros1.ground.names import canonicalize_name
from rospy.exceptions import ROSException, ROSInitException

SEP = GLOBALNS = "/"
REMAP = ":="
ANYTYPE = TOPIC_ANYTYPE = SERVICE_ANYTYPE = "*"


def isstring(s: object) -> bool:
    """Return whether a value is a str."""
    return isinstance(s, str)


def normalize_name_argument(name: Any) -> str:
    """Convert a name that a program passed, as stock does: None to the empty name, and ``~/x`` to ``/x``."""
    text = "" if name is None else str(name)
    return text[1:] if text[:2] == "~/" and text.strip("~/") else text


def is_global(name: str) -> Any:
    """Return whether a name is global; an empty name is returned unchanged."""
    return name and name[0] == SEP


def is_private(name: str) -> Any:
    """Return whether a name is private; an empty name is returned unchanged."""
    return name and name[0] == "~"


def ns_join(ns: str, name: str) -> str:
    """Join a namespace and a name; a global or private name is returned unchanged."""
    return names.ns_join(ns, name)


def namespace(name: str) -> str:
    """Return the namespace of a name, with a trailing slash.

    Raises:
        ValueError: the name is None.
        TypeError: the name is not a str.
    """
    if name is None:
        raise ValueError("name")
    if not isinstance(name, str):
        raise TypeError("name")
    return names.namespace(name)


_command_line: dict[str, list[str]] = {}
"""The command line set by `reload_mappings`, under the key "argv"; it replaces the process's own."""


_early_remappings: dict[str, str] = {}
"""The remappings set by `initialize_mappings`."""


_program_name: dict[str, str] = {}
"""The node's full name set by `_set_caller_id`, under the key "id"."""


def _set_caller_id(caller_id: str) -> None:
    """Set the program's full name until a node is started.

    Raises:
        ValueError: the name is None.
        TypeError: the name is not a str.
    """
    namespace(caller_id)
    if not _program_name:
        PROCESS.add_start_callback(lambda _: _program_name.clear())
    _program_name["id"] = caller_id


def _arguments() -> names.Arguments:
    if PROCESS.node is not None:
        return PROCESS.node.arguments
    return names.parse_arguments(_command_line.get("argv", sys.argv))


def reload_mappings(argv: list[str]) -> None:
    """Use the remappings on a command line until the node starts with the ones passed to `rospy.init_node`."""
    _command_line["argv"] = list(argv)


def get_caller_id() -> str:
    """Return the node's full name; before it is started, ``unnamed`` in its namespace."""
    if PROCESS.node is not None:
        return PROCESS.node.name
    return _program_name["id"] if "id" in _program_name else get_namespace() + "unnamed"


def get_name() -> str:
    """Return the node's full name; before it is started, ``unnamed`` in its namespace."""
    return get_caller_id()


def get_namespace() -> str:
    """Return the node's namespace, with a trailing slash."""
    if PROCESS.node is not None:
        return names.namespace(PROCESS.node.name)
    if "id" in _program_name:
        return names.namespace(_program_name["id"])
    namespace_text = _arguments().special.get("__ns") or os.environ.get("ROS_NAMESPACE", "")
    return canonicalize_name(f"/{namespace_text}/").rstrip(SEP) + SEP


def get_mappings() -> dict[str, str]:
    """Return the remappings on the command line, including special ones like ``__ns``, without resolving them."""
    arguments = _arguments()
    return {**arguments.special, **{old: new for old, new in arguments.remappings.items() if new}}


def get_resolved_mappings() -> dict[str, str]:
    """Return the name remappings on the command line, with full names.

    There are none before the node is started or `initialize_mappings` is called.
    """
    if PROCESS.node is None:
        return dict(_early_remappings)
    return {**PROCESS.node.arguments.special, **_resolved_remappings(PROCESS.node.name)}


def _resolved_remappings(caller: str) -> dict[str, str]:
    return {_full_name(old, caller): _full_name(new, caller) for old, new in _arguments().remappings.items() if new}


def _full_name(name: str, caller_id: str) -> str:
    """Return the full name without applying remappings. As in stock ROS, illegal names are accepted."""
    if not name:
        return namespace(caller_id)
    name = canonicalize_name(str(name))
    if is_global(name):
        return name
    if is_private(name):
        return ns_join(caller_id, name[1:])  # ~/x is /x, unlike in roscpp
    return namespace(caller_id) + name


def resolve_name(name: str, caller_id: str | None = None) -> str:
    """Resolve a name in a node, apply remappings, and return the full name.

    Args:
        name: any name; it may be illegal.
        caller_id: full name of the node; None for the program's own.
    """
    full_name = _full_name(name, caller_id or get_caller_id())
    if not name:
        return full_name
    if PROCESS.node is None:
        return _early_remappings.get(full_name, full_name)
    if not PROCESS.node.arguments.remappings:
        return full_name
    return _resolved_remappings(PROCESS.node.name).get(full_name, full_name)


def warn_if_illegal_name(name: str, depth: int) -> None:
    """Warn about an illegal name.

    Args:
        name: any name.
        depth: number of stack frames between the program and the warning.
    """
    if not names.is_legal_name(canonicalize_name(name)):
        text = f"'{name}' is not a legal ROS graph resource name. This may cause problems with other ROS tools"
        warnings.warn(text, stacklevel=depth)


def resolve_name_without_node_name(name: str) -> str:
    """Resolve a name before the node is started, apply remappings, and return the full name.

    Raises:
        ValueError: the name is private.
    """
    if is_private(name):
        raise ValueError("~name topics cannot be created before init_node() has been called")
    caller = get_caller_id()
    full_name = _full_name(name, caller)
    return _resolved_remappings(caller).get(full_name, full_name)


def remap_name(name: str, caller_id: str | None = None, resolved: bool = True) -> str:
    """Return the full name that a name is remapped to, or the name itself.

    A remapping applies only if it is for exactly this name: ``a:=b`` does not apply to ``/a``. `resolve_name` compares
    full names.

    Args:
        name: any name.
        caller_id: full name of the node in which the new name is resolved; None for the program's own.
        resolved: not used, as in stock ROS.
    """
    new_name = get_mappings().get(name)
    return name if new_name is None else _full_name(new_name, caller_id or get_caller_id())


def scoped_name(caller_id: str, name: str) -> str:
    """Return a name relative to a node's namespace if it is in that namespace.

    Raises:
        ROSException: one of the names is not global.
    """
    if not is_global(caller_id):
        raise ROSException("caller_id must be global")
    if not is_global(name):
        raise ROSException("name must be global")
    scope = namespace(caller_id)
    return name[len(scope) :] if name.startswith(scope) and name != scope else name


def initialize_mappings(node_name: str) -> None:
    """Resolve the remappings on the command line for a node that has not been started; starting it also does this.

    Args:
        node_name: the full name of the node.
    """
    arguments = _arguments()
    _early_remappings.clear()
    _early_remappings.update({**arguments.special, **_resolved_remappings(node_name)})


# Checks of arguments --------------------------------------------------------------------------------------------------


def valid_name_validator_resolved(param_name: str, param_value: Any, caller_id: str) -> str:
    """Validate a name, and return the full name.

    Raises:
        ParameterInvalid: the value is not a name.
    """
    name = valid_name_validator_unresolved(param_name, param_value, caller_id)
    return names.resolve_name(name, caller_id, strict=False)  # only here, ~/x is below the node


def valid_name_validator_unresolved(param_name: str, param_value: Any, caller_id: str) -> str:
    """Validate a name and return it unchanged.

    Raises:
        ParameterInvalid: the value is not a name.
    """
    from rospy.impl.validators import ParameterInvalid

    if not param_value or not isinstance(param_value, str):
        raise ParameterInvalid(f"ERROR: parameter [{param_name}] must be a non-empty string")
    if ":" in param_value or " " in param_value:
        raise ParameterInvalid(f"ERROR: parameter [{param_name}] contains illegal chars")
    return param_value


def valid_name(param_name: str, resolve: bool = True) -> Callable[[Any, str], str]:
    """Return a validator of names, which is called with (value, caller id)."""
    check = valid_name_validator_resolved if resolve else valid_name_validator_unresolved
    return lambda value, caller_id: check(param_name, value, caller_id)


def global_name(param_name: str) -> Callable[[Any, str], str]:
    """Return a validator of full names, which is called with (value, caller id)."""

    def check(value: Any, caller_id: str) -> str:
        from rospy.impl.validators import ParameterInvalid

        if not value or not isinstance(value, str):
            raise ParameterInvalid(f"ERROR: parameter [{param_name}] must be a non-empty string")
        if not is_global(value):
            raise ParameterInvalid(f"ERROR: parameter [{param_name}] must be a globally referenced name")
        return value

    return check


LAZY_IMPORTS = {
    "ParameterInvalid": "rospy.impl.validators",
    "get_ros_namespace": "rosgraph.names",
    "load_mappings": "rosgraph.names",
    "make_global_ns": "rosgraph.names",
}
"""Names that this module imports lazily, as do the modules that re-export all of its names."""
__getattr__, __dir__ = _module_hooks(
    __name__,
    LAZY_IMPORTS,
    computed_values={
        "_caller_namespace": get_namespace,
        "_caller_id": get_caller_id,
        "_mappings": get_mappings,
        "_resolved_mappings": get_resolved_mappings,
    },
)
