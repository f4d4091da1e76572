"""Reading launch files (https://wiki.ros.org/roslaunch/XML)."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

from pyros1.drop_in.missing import missing
from pyros1.ground.errors import Error
from pyros1.launch.plan import Plan
from pyros1.launch.reading.loader import ATTRIBUTES, load_plan
from pyros1.launch.reading.report import contents
from pyros1.launch.reading.words import parse_arguments
from pyros1.launch.reading.world import make_resources
from roslaunch.core import Machine, Node, Param, RLException, Test
from roslaunch.loader import Loader
from roslaunch.plans import machine_of, node_of
from roslaunch.substitution_args import ArgException, SubstitutionException

__all__ = [
    "ArgException",
    "Machine",
    "Node",
    "Param",
    "RLException",
    "SubstitutionException",
    "Test",
    "XmlLoader",
    "XmlParseException",
]

NS = "ns"
CLEAR_PARAMS = "clear_params"
__getattr__ = missing(
    "roslaunch.xmlloader",
    ifunless="launch files are read by pyros1.launch.reading",
    ifunless_test="launch files are read by pyros1.launch.reading",
)


class XmlParseException(RLException):
    """A launch file is wrong."""


class XmlLoader(Loader):
    """Reads launch files into a ROSLaunchConfig.

    Args:
        resolve_anon: accepted for compatibility: ``$(anon x)`` is always resolved.
        args_only: read only the arguments; `root_context` has them.
    """

    def __init__(self, resolve_anon: bool = True, args_only: bool = False) -> None:
        self.resolve_anon = resolve_anon
        self.args_only = args_only
        self.root_context: Any = None

    ROSPARAM_OPT_ATTRS = ("command", "ns", "file", "param", "subst_value")
    PARAM_ATTRS = ("name", "value", "type", "value", "textfile", "binfile", "command")
    ARG_ATTRS = ATTRIBUTES["arg"]
    NODE_ATTRS = [name for name in ATTRIBUTES["node"] if name[:5] != "wait-"]
    TEST_ATTRS = [name for name in ATTRIBUTES["test"] if name[:5] != "wait-"]
    MACHINE_ATTRS = ATTRIBUTES["machine"]
    REMAP_ATTRS = ATTRIBUTES["remap"]
    ENV_ATTRS = ATTRIBUTES["env"]
    INCLUDE_ATTRS = ATTRIBUTES["include"]
    GROUP_ATTRS = tuple(name for name in ATTRIBUTES["group"] if name[:5] != "wait-")

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"pyros1 has no roslaunch XmlLoader.{name}: pyros1.launch.reading reads launch files")

    def load(
        self, filename: str, ros_config: Any, core: bool = False, argv: list[str] | None = None, verbose: bool = True
    ) -> None:
        """Read a file.

        Args:
            filename: its path.
            ros_config: the ROSLaunchConfig to fill.
            core: whether its nodes are those of the core.
            argv: ``name:=value`` words; None for those of the program's command line.
            verbose: print what is read.

        Raises:
            XmlParseException: the file cannot be used.
        """
        self._load(filename, make_resources(), ros_config, core, sys.argv if argv is None else argv, verbose)

    def load_string(self, xml_text: str, ros_config: Any, core: bool = False, verbose: bool = True) -> None:
        """Read a file's contents; see `load`."""
        resources = replace(make_resources(), stdin=lambda: xml_text)
        self._load("-", resources, ros_config, core, [], verbose)

    def _load(self, file: str, resources: Any, config: Any, core: bool, words: list[str], verbose: bool) -> None:
        try:
            plan = load_plan([file], parse_arguments(words), resources, only_args=self.args_only)
        except Error as error:
            raise XmlParseException(str(error)) from error
        self.root_context = plan
        if verbose:
            print(contents(plan))
        for warning in plan.warnings:
            config.logger.warning("%s", warning)
        for name in plan.files:
            if name != "<stdin>":
                config.add_roslaunch_file(name)
        self._fill(plan, config, core)

    @staticmethod
    def _fill(plan: Plan, config: Any, core: bool) -> None:
        for name in plan.clear_params:
            config.add_clear_param(name)
        for name, value in plan.params.items():
            config.add_param(Param(name, value), verbose=False)
        for machine in plan.machines.values():
            config.add_machine(machine_of(machine), verbose=False)
        config.actions.extend(plan.actions)
        for node in plan.nodes:
            config.add_node(node_of(node), core=core, verbose=False)
        for test in plan.tests:
            config.add_test(node_of(test), verbose=False)
