"""Determines a node's full name from the program, its command line and the environment (N07-N09)."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping

from pyros1.ground import names
from pyros1.ground.errors import InvalidNameError


def namespace_and_name(
    name: str,
    anonymous: bool,
    namespace: str | None,
    special: Mapping[str, str],
    environ: Mapping[str, str],
    strict: bool = True,
) -> tuple[str, str]:
    """Return a node's namespace and full name.

    Args:
        name: base name set by the program; ``__name`` replaces it and disables ``anonymous``.
        anonymous: whether to append the process id and the time.
        namespace: namespace set by the program; takes precedence over ROS_NAMESPACE, but not over ``__ns``.
        special: the command line's ``__key:=value`` arguments.
        environ: environment variables.
        strict: whether the name must follow the naming rules.

    Raises:
        InvalidNameError: the name or the namespace is not legal.
    """
    if special.get("__name"):
        name = special["__name"]
    elif anonymous:
        name = names.anonymous_name(name, os.getpid(), int(time.time() * 1000))
    if strict and not names.is_legal_base_name(name):
        raise InvalidNameError(
            f"{name!r} is not a legal node name: it must start with a letter and contain only letters, digits and '_' "
            "(set a namespace with __ns:= or ROS_NAMESPACE)"
        )
    ns = special.get("__ns") or namespace or environ.get("ROS_NAMESPACE") or names.SEP
    ns = names.canonicalize_name(names.SEP + ns.strip(names.SEP)) or names.SEP
    if strict and not names.is_legal_name(ns):
        raise InvalidNameError(f"{ns!r} is not a legal namespace")
    return ns, names.canonicalize_name(names.ns_join(ns, name))
