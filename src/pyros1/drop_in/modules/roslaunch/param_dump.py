"""Prints the parameters of launch files."""

from __future__ import annotations

from typing import Any

from pyros1.launch.running.core import CORE_PARAMS
from pyros1.values import dump_yaml
from roslaunch.config import load_config_default


def dump_params(files: Any) -> bool:
    """Print all parameters of launch files, except a core's, as YAML; return True."""
    config = load_config_default(files, None, verbose=False, assign_machines=False)
    print(dump_yaml({name: param.value for name, param in config.params.items() if name not in CORE_PARAMS}))
    return True
