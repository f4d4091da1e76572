"""A configuration: a dictionary of parameters that are also available as attributes."""

from __future__ import annotations

from typing import Any


class _MissingParameterError(AttributeError, KeyError):
    """There is no such parameter; both an AttributeError and a KeyError."""

    def __str__(self) -> str:
        return AttributeError.__str__(self)


class Config(dict[str, Any]):
    """The values of parameters by name, also as attributes: ``config.rate`` is ``config["rate"]``."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise _MissingParameterError(name) from None

    def __setattr__(self, name: str, value: Any) -> None:
        self[name] = value

    def copy(self) -> Config:
        """Return a copy; the tree of groups is shared."""
        return type(self)(self)
