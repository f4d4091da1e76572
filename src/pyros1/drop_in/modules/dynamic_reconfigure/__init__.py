"""Parameters that can be changed while a node is running (https://wiki.ros.org/dynamic_reconfigure)."""

from __future__ import annotations

from collections.abc import KeysView
from typing import Any

from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr(__name__)


class DynamicReconfigureException(Exception):
    """Base class of this package's exceptions."""


class DynamicReconfigureParameterException(DynamicReconfigureException):
    """A parameter does not exist, or the value is not valid for it."""


class DynamicReconfigureCallbackException(DynamicReconfigureException):
    """A server's callback has refused a change."""


def find_reconfigure_services() -> list[str]:
    """Return the names of the servers registered with the master, without ``/set_parameters``, sorted."""
    import os

    from pyros1.net.hosts import master_uri
    from pyros1.net.master_client import MasterClient

    suffix = "/set_parameters"
    services = MasterClient("/find_reconfigure_services", master_uri(os.environ, {})).get_system_state()[2]
    return sorted(name.removesuffix(suffix) for name, _ in services if name.endswith(suffix))


def get_parameter_names(descr: Any) -> KeysView[str]:
    """Return the names of the parameters in a module that was created from a ``.cfg`` file."""
    names: KeysView[str] = descr.defaults.keys()
    return names
