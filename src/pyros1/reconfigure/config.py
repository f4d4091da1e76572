"""A configuration: a dictionary of parameter values, which are also available as attributes."""

from __future__ import annotations

from typing import Any


class _MissingParameterError(AttributeError, KeyError):
    """There is no parameter with the requested name. The error is both an AttributeError and a KeyError."""

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
        """Return a copy that shares the tree of groups with the original."""
        return type(self)(self)
