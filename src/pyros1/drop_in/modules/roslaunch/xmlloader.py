"""Reads launch files (https://wiki.ros.org/roslaunch/XML)."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

from pyros1.drop_in.module_attributes import class_getattr, module_getattr
from pyros1.ground.errors import Error
from pyros1.launch.plan import Plan
from pyros1.launch.reading.cli_arguments import parse_arguments
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.report import list_contents
from pyros1.launch.reading.system_resources import make_resources
from roslaunch.core import Param, RLException
from roslaunch.plans import to_machine, to_node

__all__ = ["XmlLoader", "XmlParseException"]

_READING = "pyros1.launch.reading reads launch files; see XmlLoader.load"
__getattr__ = module_getattr("roslaunch.xmlloader", ifunless=_READING, ifunless_test=_READING)


class XmlParseException(RLException):
    """A launch file is invalid."""


class XmlLoader:
    """Reads launch files into a ROSLaunchConfig.

    Args:
        resolve_anon: accepted for compatibility: ``$(anon x)`` is always resolved.
        args_only: whether to read only the arguments, into `root_context`.
    """

    def __init__(self, resolve_anon: bool = True, args_only: bool = False) -> None:
        self.resolve_anon = resolve_anon
        self.args_only = args_only
        self.root_context: Any = None

    __getattr__ = class_getattr(
        "XmlLoader",
        _READING,
        frozenset(["add_param", "load_env", "load_rosparam", "opt_attrs", "param_value", "reqd_attrs", "resolve_args"]),
    )

    def load(
        self, filename: str, ros_config: Any, core: bool = False, argv: list[str] | None = None, verbose: bool = True
    ) -> None:
        """Read a file.

        Args:
            filename: path of the file.
            ros_config: the ROSLaunchConfig to fill.
            core: whether the file's nodes belong to the core.
            argv: ``name:=value`` words; None for the ones on the program's command line.
            verbose: whether to print a list of the file's contents.

        Raises:
            XmlParseException: the file cannot be used.
        """
        self._load(filename, make_resources(), ros_config, core, sys.argv if argv is None else argv, verbose)

    def load_string(self, xml_text: str, ros_config: Any, core: bool = False, verbose: bool = True) -> None:
        """Read a launch file from a string; see `load`."""
        resources = replace(make_resources(), read_stdin=lambda: xml_text)
        self._load("-", resources, ros_config, core, [], verbose)

    def _load(self, file: str, resources: Any, config: Any, core: bool, words: list[str], verbose: bool) -> None:
        try:
            plan = load_plan([file], parse_arguments(words), resources, only_args=self.args_only)
        except Error as error:
            raise XmlParseException(str(error)) from error
        self.root_context = plan
        if verbose:
            print(list_contents(plan))
        for warning in plan.warnings:
            config.logger.warning("%s", warning)
        for name in plan.files:
            if name != "<stdin>":
                config.add_roslaunch_file(name)
        self._add_to_config(plan, config, core)

    @staticmethod
    def _add_to_config(plan: Plan, config: Any, core: bool) -> None:
        for name in plan.clear_params:
            config.add_clear_param(name)
        for name, value in plan.params.items():
            config.add_param(Param(name, value), verbose=False)
        for machine in plan.machines.values():
            config.add_machine(to_machine(machine), verbose=False)
        config.actions.extend(plan.actions)
        for node in plan.nodes:
            config.add_node(to_node(node), core=core, verbose=False)
        for test in plan.tests:
            config.add_test(to_node(test), verbose=False)
