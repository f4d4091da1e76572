"""Definitions of services (https://wiki.ros.org/srv)."""

from __future__ import annotations

from genmsg.msgs import MsgSpec
from genmsg.names import is_legal_resource_base_name, is_legal_resource_name, package_resource_name, resource_name
from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)


class SrvSpec:
    """A service's definition.

    Args:
        request, response: definitions of both messages.
        text: the definition as written.
        full_name: ``package/Type``.
        short_name: the name without the package.
        package: the package.
    """

    def __init__(
        self,
        request: MsgSpec,
        response: MsgSpec,
        text: str,
        full_name: str = "",
        short_name: str = "",
        package: str = "",
    ) -> None:
        self.request = request
        self.response = response
        self.text = text
        own_package, own_name = package_resource_name(full_name)
        self.full_name = full_name
        self.short_name = short_name or own_name
        self.package = package or own_package

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, SrvSpec):
            return False
        names = ("request", "response", "text", "full_name", "short_name", "package")
        return all(getattr(self, name) == getattr(other, name) for name in names)

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"SrvSpec[{self.request!r}, {self.response!r}]"
