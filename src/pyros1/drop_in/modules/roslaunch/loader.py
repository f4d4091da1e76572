"""The base of what reads launches, and its errors."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from typing import Any, Literal
from xmlrpc.client import Binary

from pyros1.drop_in.missing import missing
from pyros1.ground.errors import LaunchError
from pyros1.ground.names import ns_join
from pyros1.launch.plan import ParamFileAction
from pyros1.launch.reading.convert import convert_value as _convert
from pyros1.launch.reading.world import run_command
from pyros1.values import YamlError, load_yaml
from roslaunch.core import Param, RLException


class LoadException(RLException):
    """Something in a launch cannot be read."""


class Loader:
    """Base of XmlLoader: what its tags do. A ``context`` has the attributes ``ns`` and ``env_args``."""

    def add_param(self, ros_config: Any, param_name: str, param_value: Any, verbose: bool = True) -> None:
        """Add a parameter; a dictionary is a namespace.

        Args:
            ros_config: the ROSLaunchConfig to fill.
            param_name: full name. param_value: its value.
            verbose: print what is added.

        Raises:
            ValueError: there is no name.
        """
        if not param_name:
            raise ValueError("no parameter name specified")
        for name, value in _leaves(param_name, param_value):
            ros_config.add_param(Param(name, value), verbose=verbose)

    def load_env(self, context: Any, ros_config: Any, name: str, value: str) -> None:
        """Add an environment variable to the context's; raises ValueError without a name."""
        if not name:
            raise ValueError("'name' attribute must be non-empty")
        context.env_args.append((name, value))

    def load_rosparam(
        self,
        context: Any,
        ros_config: Any,
        cmd: str,
        param: str | None,
        file_: str | None,
        text: str | None,
        verbose: bool = True,
        subst_function: Callable[[str], str] | None = None,
    ) -> None:
        """Do what a <rosparam> tag says.

        Args:
            context: its ``ns`` is the namespace.
            ros_config: the ROSLaunchConfig to fill.
            cmd: "load", "dump" or "delete".
            param: name of the parameter or namespace.
            file_: path of a file. text: its contents, if there is no file.
            verbose: print what is added.
            subst_function: changes the text first.

        Raises:
            ValueError: something is missing or wrong.
        """
        name = ns_join(context.ns, param or "")
        if cmd in ("dump", "delete"):
            if cmd == "delete" and file_ is not None:
                raise ValueError("'file' attribute is invalid with 'delete' command.")
            action: Literal["dump", "delete"] = "dump" if cmd == "dump" else "delete"
            ros_config.actions.append(ParamFileAction(action, name, file_ or ""))
            return
        if cmd != "load":
            raise ValueError("command must be 'load', 'dump', or 'delete'")
        if file_:
            try:
                with open(file_, encoding="utf-8") as file:
                    text = file.read()
            except FileNotFoundError:
                raise ValueError(f"file does not exist [{file_}]") from None
        text = text or ""
        if subst_function is not None:
            text = subst_function(text)
        try:
            value = load_yaml(text)
        except YamlError as error:
            what = f"file {file_} contains invalid YAML:\n{error}"
            raise ValueError(what if file_ else f"Error within YAML block:\n\t{error}\n\nYAML is:\n{text}") from error
        if value is None:
            return
        if not (param or isinstance(value, dict)):
            raise ValueError("'param' attribute must be set for non-dictionary values")
        self.add_param(ros_config, name, value, verbose=verbose)

    def param_value(
        self,
        verbose: bool,
        name: str,
        ptype: str,
        value: str | None,
        textfile: str | None,
        binfile: str | None,
        command: str | None,
    ) -> Any:
        """Return the value of a <param> tag.

        Args:
            verbose: print commands that are run.
            name: the parameter, for error messages. ptype: see `convert_value`.
            value: its text. textfile, binfile: paths of files with it. command: prints it. The first that is not None
                counts.

        Raises:
            ValueError: there is no value, or it is not of the type. OSError: a file cannot be read.
        """
        if value is not None:
            return convert_value(value.strip(), ptype)
        if textfile is not None:
            with open(textfile, encoding="utf-8") as file:
                return convert_value(file.read(), ptype)
        if binfile is not None:
            with open(binfile, "rb") as binary:
                return Binary(binary.read())
        if command is None:
            raise ValueError("unable to determine parameter value")
        if verbose:
            print(f"... executing command param [{command}]")
        try:
            output = run_command(shlex.split(command))
        except (LaunchError, IndexError) as error:
            raise ValueError(f"Cannot load command parameter [{name}]: {str(error).rstrip('.')}") from error
        return convert_value(output, ptype)


def _leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    if not isinstance(value, dict):
        yield name, value
        return
    for key, item in value.items():
        yield from _leaves(ns_join(name, key), item)


def convert_value(value: str, type_: str) -> Any:
    """Return a parameter's value from its text.

    Args:
        value: the text.
        type_: "str", "int", "double", "bool", "auto" or "yaml".

    Raises:
        ValueError: the text has another type.
    """
    try:
        return _convert(value, type_.lower())
    except LaunchError as error:
        cause = error.__cause__
        raise ValueError(str(cause if isinstance(cause, ValueError) else error)) from error


__getattr__ = missing(
    "roslaunch.loader",
    LoaderContext="launch files are read by pyros1.launch.reading",
    load_mappings="launch files are read by pyros1.launch.reading",
    load_sysargs_into_context="launch files are read by pyros1.launch.reading",
    post_process_include_args="launch files are read by pyros1.launch.reading",
    process_include_args="launch files are read by pyros1.launch.reading",
    rosparam="launch files are read by pyros1.launch.reading",
    PRIV_NAME="launch files are read by pyros1.launch.reading",
)
