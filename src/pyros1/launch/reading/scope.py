"""The settings that apply at a place in a launch file: namespace, arguments, remappings, environment and so on."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from typing import Any

from pyros1.ground.errors import LaunchError
from pyros1.ground.names import canonicalize_name, is_legal_name, is_private, ns_join
from pyros1.ground.suggest import did_you_mean
from pyros1.launch.reading.resources import Resources


@dataclass
class Scope:
    """The scope of an element. Groups and includes get copies, so that their changes stay local (X60, X61).

    Attributes:
        resources: access to files, packages and the environment.
        file: the current file.
        is_included: whether another file has included this file.
        namespace: the namespace, with a trailing slash.
        args: arguments that have a value: from the command line, the ``<include>``, or an ``<arg>`` in this file.
        declared: names of all ``<arg>`` tags in this file so far.
        pass_all: whether ``pass_all_args`` is set, so that ``<arg>`` tags may change existing values.
        known_args: names of all arguments that any file has declared or used; all scopes share one set.
        remappings: ``from`` -> ``to``.
        env: environment variables to set.
        private_params: ``(name, value)`` of the private parameters to set for all later nodes.
        default_machine: machine of nodes without a ``machine`` attribute.
        wait_for: the ``wait-for`` conditions of the enclosing groups.
        wait_timeout: the ``wait-timeout`` of the innermost group that has one.
        anonymous_names: identifier -> the name that ``$(anon identifier)`` stands for.
    """

    resources: Resources
    file: str
    is_included: bool = False
    namespace: str = "/"
    args: dict[str, str] = field(default_factory=dict)
    declared: set[str] = field(default_factory=set)
    pass_all: bool = False
    known_args: set[str] = field(default_factory=set)
    remappings: dict[str, str] = field(default_factory=dict)
    env: dict[str, str] = field(default_factory=dict)
    private_params: list[tuple[str, Any]] = field(default_factory=list)
    default_machine: str | None = None
    wait_for: str = ""
    wait_timeout: str = ""
    anonymous_names: dict[str, str] = field(default_factory=dict)

    def child(self, namespace: str | None = None, **changes: Any) -> Scope:
        """Return a copy for a group or an include.

        Args:
            namespace: the relative or global namespace; None for no change.
            changes: other attributes to replace.

        Raises:
            LaunchError: the namespace is private.
        """
        child_namespace = self.namespace
        if namespace is not None:
            child_namespace = ns_join(self.namespace, namespace)
            if is_private(child_namespace):
                raise LaunchError(f"a namespace cannot be private: {namespace}")
            child_namespace = canonicalize_name(child_namespace).rstrip("/") + "/"
        copies: dict[str, Any] = {
            "args": dict(self.args),
            "declared": set(self.declared),
            "remappings": dict(self.remappings),
            "env": dict(self.env),
            "private_params": list(self.private_params),
            "anonymous_names": dict(self.anonymous_names),
            "pass_all": False,
        }
        return replace(self, **{**copies, "namespace": child_namespace, **changes})

    def declare(self, name: str, value: str | None, default: str | None) -> None:
        """Apply an ``<arg>`` tag (X57).

        Args:
            name: name of the argument.
            value: the fixed value; None if there is none.
            default: the default; None if there is none.

        Raises:
            LaunchError: the argument is declared twice in a file, or would override a fixed value.
        """
        if name in self.declared and not self.pass_all:
            raise LaunchError(f"arg '{name}' has already been declared")
        self.declared.add(name)
        self.known_args.add(name)
        if value is not None:
            if name in self.args and not self.pass_all:
                raise LaunchError(f"cannot override arg '{name}', which has already been set")
            self.args[name] = value
        elif default is not None:
            self.args.setdefault(name, default)

    def remap(self, old: str | None, new: str | None) -> None:
        """Apply a ``<remap>`` tag; it replaces an earlier remapping of the same name (X67).

        Raises:
            LaunchError: an attribute is missing or not a legal name.
        """
        if not old or not new:
            raise LaunchError("<remap> tag is missing required from/to attributes")
        for side, name in (("from", old), ("to", new)):
            if not is_legal_name(canonicalize_name(name)):
                raise LaunchError(f"remap {side} [{name}] is not a valid ROS name")
        self.remappings.pop(canonicalize_name(old), None)
        self.remappings[canonicalize_name(old)] = canonicalize_name(new)

    def set_env(self, name: str | None, value: str | None) -> None:
        """Apply an ``<env>`` tag (X68).

        Raises:
            LaunchError: an attribute is missing, or cannot be stored in an environment.
        """
        if not name or value is None:
            raise LaunchError("<env> tag is missing required name/value attributes")
        if "=" in name or "\0" in name + value:
            raise LaunchError(f"not a valid name or value of an environment variable: {name!r}")
        self.env[name] = value

    # Environment ---------------------------------------------------------------------------------------------------

    def env_value(self, name: str) -> str:
        """Return the value of an environment variable.

        Raises:
            LaunchError: the variable is not set.
        """
        value = self.resources.environ.get(name)
        if value is None:
            raise LaunchError(f"environment variable '{name}' is not set")
        return value


class ArgNotSetError(LaunchError):
    """A required argument has no value."""


class ScopeSubstituter:
    """Provides the values that replace ``$(...)`` for the elements of a scope.

    Args:
        scope: the scope from which the values come.
    """

    def __init__(self, scope: Scope) -> None:
        self._scope = scope

    def env(self, name: str) -> str:
        """Return the value of an environment variable."""
        return self._scope.env_value(name)

    def optional_env(self, name: str, default: str) -> str:
        """Return the value of an environment variable, or the default."""
        return self._scope.resources.environ.get(name, default)

    def find(self, package: str, path: str) -> str:
        """Return the path for ``$(find package)path``; see `Resources.find`."""
        return self._scope.resources.find(package, path)

    def anon(self, identifier: str) -> str:
        """Return the unique name for an identifier; within a file, each call returns the same name."""
        names = self._scope.anonymous_names
        if identifier not in names:
            unique = f"{identifier}_{self._scope.resources.make_unique_suffix()}"
            names[identifier] = unique.replace(".", "_").replace("-", "_").replace(":", "_")
        return names[identifier]

    def arg(self, name: str) -> str:
        """Return an argument's value (X58).

        Raises:
            ArgNotSetError: the argument has no value; the message contains the file's name.
        """
        self._scope.known_args.add(name)
        value = self._scope.args.get(name)
        if value is None:
            prefix = "included file " if self._scope.is_included else ""
            declared = self._scope.declared
            hint = "" if name in declared else did_you_mean(name, declared) or did_you_mean(name, self._scope.args)
            raise ArgNotSetError(f"{prefix}[{self._scope.file}] requires the '{name}' arg to be set{hint}")
        return value

    def dirname(self) -> str:
        """Return the folder of the current file."""
        return os.path.abspath(os.path.dirname(self._scope.file))

    def args(self) -> dict[str, str]:
        """Return all arguments that have a value."""
        return self._scope.args
