"""Access to the parameters that pages may see."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import ParameterNotSetError
from pyros1.net.master_client import MasterClient
from pyros1.web.models.params import flatten
from pyros1.web.server.access import Access

_HIDDEN = object()


class Parameters:
    """Access to parameters for pages. Namespaces are returned without the parameters that pages are not allowed to see.

    Args:
        master: the master with the parameters.
        access: the access rules.
        check_visible: raises an error if pages are not allowed to see a name.
    """

    def __init__(self, master: MasterClient, access: Access, check_visible: Callable[[str], None]) -> None:
        self._master = master
        self._access = access
        self._check_visible = check_visible

    def get(self, name: str) -> Any:
        """Return a parameter, or all parameters in a namespace as a dictionary.

        Args:
            name: a full name; ``/`` for all parameters.

        Raises:
            RequestError: pages are not allowed to see the parameter.
            ParameterNotSetError: the parameter is not set.
            MasterUnreachableError: the master does not respond.
        """
        name = _full_name(name)
        try:
            value = self._visible_part(name.rstrip("/"), self._master.get_param(name))
        except ParameterNotSetError:
            self._check_visible(name)
            raise
        if value is _HIDDEN:
            if name == "/":
                return {}
            self._check_visible(name)
            return {}  # a visible namespace that contains nothing visible
        return value

    def has(self, name: str) -> bool:
        """Return whether a parameter is set and visible to pages, or a namespace contains such a parameter."""
        name = _full_name(name)
        if not self._access.topics:
            return self._master.has_param(name)
        try:
            return self._visible_part(name.rstrip("/"), self._master.get_param(name)) is not _HIDDEN
        except ParameterNotSetError:
            return False

    def names(self) -> list[str]:
        """Return the sorted full names of all parameters that pages may see."""
        return self._access.visible_names(sorted(self._master.get_param_names()))

    def set(self, name: str, value: Any) -> None:
        """Set a parameter, or replace all parameters in a namespace.

        Raises:
            RequestError: something that would be set or replaced is hidden from pages.
            MasterUnreachableError: the master does not respond.
        """
        name = _full_name(name)
        self._check_all_visible(name, value)
        self._check_all_visible(name)
        self._master.set_param(name, value)

    def delete(self, name: str) -> None:
        """Delete a parameter, or all parameters in a namespace.

        Raises:
            RequestError: pages are not allowed to see everything that would be deleted.
            ParameterNotSetError: the parameter is not set.
            MasterUnreachableError: the master does not respond.
        """
        name = _full_name(name)
        self._check_all_visible(name)
        self._master.delete_param(name)

    def _visible_part(self, name: str, value: Any) -> Any:
        if not self._access.topics:
            return value
        if isinstance(value, dict) and value:
            children = {key: self._visible_part(f"{name}/{key}", child) for key, child in value.items()}
            return {key: child for key, child in children.items() if child is not _HIDDEN} or _HIDDEN
        return value if self._access.may_see(name or "/") else _HIDDEN

    def _check_all_visible(self, name: str, value: Any = _HIDDEN) -> None:
        """Check that pages may see all parameters in a namespace: in its new value or, by default, its current one."""
        if not self._access.topics:
            return
        if value is _HIDDEN:
            current: Any = self._master.get_param("/")
            path = ""
            for part in filter(None, name.split("/")):
                if not isinstance(current, dict):
                    self._check_visible(path)  # setting `name` would replace this plain value by a namespace
                    return
                if part not in current:
                    self._check_visible(name)
                    return
                current, path = current[part], f"{path}/{part}"
            value = current
        if not isinstance(value, dict) or not value:
            self._check_visible(name)
            return
        for child_name, _ in flatten(value):
            self._check_visible(name.rstrip("/") + child_name)


def _full_name(name: str) -> str:
    return "/" + "/".join(filter(None, name.split("/")))
