"""What is in force at one place of a launch file: namespace, arguments, remappings, environment, private parameters."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from pyros1.errors import LaunchError
from pyros1.launch.resources import Resources
from pyros1.names import is_global, is_private, ns_join


@dataclass
class Scope:
    """The surroundings of a tag. Groups and includes get copies: what they change does not leak out (X60, X61).

    Attributes:
        resources: the outer world.
        file: the current file.
        included: whether the file was included by another one.
        namespace: with a slash at the end.
        args: arguments that have a value.
        declared: names of all ``<arg>`` tags seen in this file.
        given: values that override defaults here: the command line's, or the including tag's.
        pass_all: given by pass_all_args: everything may be overridden, and nothing need be declared.
        remappings: ``from`` to ``to``.
        env: variables to set.
        private_params: ``~name`` parameters for all later nodes.
        default_machine: machine that nodes get when they name none.
        anonymous: what ``$(anon x)`` has given so far, None before the first.
    """

    resources: Resources
    file: str
    included: bool = False
    namespace: str = "/"
    args: dict[str, str] = field(default_factory=dict)
    declared: set[str] = field(default_factory=set)
    given: dict[str, str] = field(default_factory=dict)
    pass_all: bool = False
    remappings: dict[str, str] = field(default_factory=dict)
    env: dict[str, str] = field(default_factory=dict)
    private_params: list[tuple[str, Any]] = field(default_factory=list)
    default_machine: str | None = None
    anonymous: dict[str, str] | None = None

    def child(self, namespace: str | None = None, **changes: Any) -> Scope:
        """Return a copy for a group or an include.

        Args:
            namespace: relative, global, or None for the same one.
            changes: other attributes to replace.
        """
        inner = self.namespace
        if namespace is not None:
            inner = namespace if is_global(namespace) else ns_join(self.namespace, namespace)
            inner = inner.rstrip("/") + "/"
        copies: dict[str, Any] = {
            "args": dict(self.args),
            "declared": set(self.declared),
            "remappings": dict(self.remappings),
            "env": dict(self.env),
            "private_params": list(self.private_params),
        }
        return replace(self, **{**copies, "namespace": inner, **changes})

    def resolve_param(self, name: str) -> str:
        """Return the full name of a parameter that is not private to a node."""
        if is_private(name):
            raise LaunchError(f"a private name cannot be resolved here: {name}")
        return name if is_global(name) else self.namespace + name

    def declare(self, name: str, value: str | None, default: Callable[[], str | None]) -> None:
        """Take an ``<arg>`` tag into account (X57).

        Args:
            name: the argument.
            value: its fixed value, None without one.
            default: gives its default (None without one); called only if it is needed.

        Raises:
            LaunchError: declared twice in a file, or a fixed value is to be overridden.
        """
        if name in self.declared:
            raise LaunchError(f"arg '{name}' has already been declared")
        self.declared.add(name)
        if value is not None:
            if name in self.given and not self.pass_all:
                raise LaunchError(f"cannot override arg '{name}', which has already been set")
            self.args[name] = value
        elif name in self.given:
            self.args[name] = self.given[name]
        else:
            text = default()
            if text is not None:
                self.args[name] = text

    # Substituter ---------------------------------------------------------------------------------------------------

    def env_value(self, name: str) -> str:
        """Return an environment variable, LaunchError if it is not set."""
        value = self.resources.environ.get(name)
        if value is None:
            raise LaunchError(f"environment variable '{name}' is not set")
        return value


class ScopeSubstituter:
    """Answers substitutions for a tag in a scope.

    Args:
        scope: the scope.
    """

    def __init__(self, scope: Scope) -> None:
        self._scope = scope

    def env(self, name: str) -> str:
        """Return an environment variable."""
        return self._scope.env_value(name)

    def optional_env(self, name: str, default: str) -> str:
        """Return an environment variable or the default."""
        return self._scope.resources.environ.get(name, default)

    def find(self, package: str, path: str) -> str:
        """Return a path in a package."""
        return self._scope.resources.find(package, path)

    def anon(self, identifier: str) -> str:
        """Return the unique name of an identifier."""
        known = self._scope.anonymous
        if known is None:
            known = self._scope.anonymous = {}
        if identifier not in known:
            unique = f"{identifier}_{self._scope.resources.unique()}"
            known[identifier] = unique.replace(".", "_").replace("-", "_").replace(":", "_")
        return known[identifier]

    def arg(self, name: str) -> str:
        """Return an argument's value; LaunchError naming the file when it has none (X58)."""
        value = self._scope.args.get(name)
        if value is None:
            if self._scope.included:
                raise LaunchError(f"included file [{self._scope.file}] requires the '{name}' arg to be set")
            raise LaunchError(f"[{self._scope.file}] requires the '{name}' arg to be set")
        return value

    def dirname(self) -> str:
        """Return the folder of the current file."""
        return os.path.abspath(os.path.dirname(self._scope.file))

    def args(self) -> dict[str, str]:
        """Return all arguments that have a value."""
        return self._scope.args
