"""Reading launch files (https://wiki.ros.org/roslaunch/XML)."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from pyros1.drop_in.missing import missing
from pyros1.ground.errors import Error
from pyros1.launch.plan import Plan
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.report import contents
from pyros1.launch.reading.words import parse_arguments
from pyros1.launch.reading.world import make_resources
from roslaunch.core import Machine, Node, Param, RLException, Test
from roslaunch.loader import Loader, convert_value
from roslaunch.plans import machine_of, node_of
from roslaunch.substitution_args import ArgException, SubstitutionException, resolve_args

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
    "ifunless",
    "ifunless_test",
]

NS = "ns"
CLEAR_PARAMS = "clear_params"
__getattr__ = missing("roslaunch.xmlloader")


class XmlParseException(RLException):
    """A launch file is wrong."""


def ifunless_test(obj: Any, tag: Any, context: Any) -> bool:
    """Return whether a tag counts by its attributes ``if`` and ``unless``.

    Args:
        obj: an XmlLoader.
        tag: an element of xml.dom.minidom.
        context: see `XmlLoader.resolve_args`.

    Raises:
        XmlParseException: it has both. ValueError: the value is not a truth value.
    """
    wanted, unwanted = obj.opt_attrs(tag, context, ["if", "unless"])
    if wanted is not None and unwanted is not None:
        raise XmlParseException("cannot set both 'if' and 'unless' on the same tag")
    if wanted is not None:
        return bool(convert_value(wanted, "bool"))
    return unwanted is None or not convert_value(unwanted, "bool")


def ifunless(f: Callable[..., Any]) -> Callable[..., Any]:
    """Make a method ``f(loader, tag, context, ...)`` do nothing with tags that do not count; see `ifunless_test`."""

    def call(*args: Any, **kwds: Any) -> Any:
        return f(*args, **kwds) if ifunless_test(*args[:3]) else None

    return call


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

    # The attributes of each tag, in stock's order.
    ROSPARAM_OPT_ATTRS = ("command", "ns", "file", "param", "subst_value")
    PARAM_ATTRS = ("name", "value", "type", "value", "textfile", "binfile", "command")
    ARG_ATTRS = ("name", "value", "default", "doc")
    NODE_ATTRS = [
        "pkg", "type", "machine", "name", "args", "output", "respawn", "respawn_delay", "cwd", "ns", "clear_params",
        "launch-prefix", "required",
    ]  # fmt: skip
    TEST_ATTRS = [*NODE_ATTRS, "test-name", "time-limit", "retry"]
    MACHINE_ATTRS = ("name", "address", "env-loader", "ssh-port", "user", "password", "default", "timeout")
    REMAP_ATTRS = ("from", "to")
    ENV_ATTRS = ("name", "value")
    INCLUDE_ATTRS = ("file", "ns", "clear_params", "pass_all_args")
    GROUP_ATTRS = ("ns", "clear_params")

    def resolve_args(self, args: str, context: Any) -> str:
        """Replace all ``$(...)`` in a text.

        Args:
            args: the text.
            context: has the attributes ``resolve_dict``, see `substitution_args.resolve_args`, and ``filename``.

        Raises:
            SubstitutionException: it is not possible.
        """
        return resolve_args(args, context.resolve_dict, self.resolve_anon, context.filename)

    def opt_attrs(self, tag: Any, context: Any, attrs: Iterable[str]) -> list[str | None]:
        """Return attributes of a tag of xml.dom.minidom, after `resolve_args`; None for those that it does not have."""
        return [
            self.resolve_args(tag.getAttribute(name), context) if tag.hasAttribute(name) else None for name in attrs
        ]

    def reqd_attrs(self, tag: Any, context: Any, attrs: Iterable[str]) -> list[str]:
        """Return attributes of a tag of xml.dom.minidom, after `resolve_args`; raises KeyError if one is not there."""
        return [self.resolve_args(tag.attributes[name].value, context) for name in attrs]

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
