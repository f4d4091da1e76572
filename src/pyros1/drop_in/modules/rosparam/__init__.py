"""rosparam, by pyros1: parameters and YAML (https://wiki.ros.org/rosparam)."""

from __future__ import annotations

import math
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from xmlrpc.client import Binary

import yaml
from rosgraph.masterapi import Master
from rosgraph.names import get_ros_namespace, make_caller_id, ns_join, script_resolve_name

from pyros1.drop_in.commands import main as _main
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground.atomic_file import write_atomically
from pyros1.ground.expressions import ExpressionError
from pyros1.values.angles import evaluate_angle as _radians

__getattr__ = module_getattr(__name__)

NAME = "rosparam"
NS = "_ns"
GLOBALNS = "/"
_INT_LIMIT = 1 << 31


class RosParamException(Exception):
    """A parameter or file is invalid."""


class RosParamIOException(RosParamException):
    """The master does not respond."""


def _get_caller_id() -> str:
    return make_caller_id(f"rosparam-{os.getpid()}")


@contextmanager
def _stock_errors() -> Iterator[None]:
    try:
        yield
    except OSError:
        raise RosParamIOException("Unable to communicate with master!") from None


def get_param_server() -> Master:
    """Return the master, which holds the parameters."""
    return Master(_get_caller_id())


def _resolve(name: str) -> str:
    return script_resolve_name(NAME, name) or GLOBALNS


# YAML: stock's additions to PyYAML's loaders and dumpers --------------------------------------------------------------


def represent_xml_binary(loader: Any, data: Any) -> Any:
    """Return binary data as YAML."""
    return loader.represent_binary(data.data)


def represent_foo(loader: Any, data: Any) -> Any:
    """Return a value as YAML with the tag ``#``."""
    return loader.represent_scalar("#", data)


def construct_yaml_binary(loader: Any, node: Any) -> Binary:
    """Convert YAML's binary data to XML-RPC's."""
    return Binary(yaml.constructor.SafeConstructor.construct_yaml_binary(loader, node))


def _angle(text: str, description: str, prefix: str) -> float:
    try:
        return _radians(_without_prefix(text, prefix))
    except ExpressionError:
        raise RosParamException(f"invalid {description}: {text}") from None


def construct_angle_radians(loader: Any, node: Any) -> float:
    """Return the value of ``rad(2*pi)`` or ``!radians 2*pi``; raises RosParamException if it is invalid."""
    return _angle(loader.construct_scalar(node), "radian expression", "rad(")


def construct_angle_degrees(loader: Any, node: Any) -> float:
    """Return ``deg(90)`` or ``!degrees 90`` in radians; raises RosParamException if it is invalid."""
    return _angle(loader.construct_scalar(node), "degree value", "deg(") * math.pi / 180.0


def _without_prefix(text: str, prefix: str) -> str:
    text = text.strip()
    return text[len(prefix) : -1] if text.startswith(prefix) else text


for _loader in (yaml.SafeLoader, yaml.FullLoader, yaml.Loader):
    _loader.add_constructor("!radians", construct_angle_radians)
    _loader.add_constructor("!degrees", construct_angle_degrees)
    _loader.add_constructor("tag:yaml.org,2002:binary", construct_yaml_binary)
    _loader.add_implicit_resolver("!radians", re.compile(r"^rad\([^\)]*\)$"), ["r"])
    _loader.add_implicit_resolver("!degrees", re.compile(r"^deg\([^\)]*\)$"), ["d"])
for _dumper in (yaml.SafeDumper, yaml.Dumper):
    _dumper.add_representer(Binary, represent_xml_binary)


# Files ---------------------------------------------------------------------------------------------------------------


def load_file(filename: str, default_namespace: str | None = None, verbose: bool = False) -> list[tuple[Any, str]]:
    """Return the documents of a YAML file, each with its namespace.

    Args:
        filename: path of the file; ``-`` is the standard input.
        default_namespace: namespace of documents without ``_ns``; None for the environment's namespace.

    Raises:
        RosParamException: there is no such file.
        yaml.YAMLError: the file is not valid YAML.
    """
    if not filename or filename == "-":
        return load_str(sys.stdin.read(), filename, default_namespace, verbose)
    if not os.path.isfile(filename):
        raise RosParamException(f"file [{filename}] does not exist")
    if verbose:
        print(f"reading parameters from [{filename}]")
    with open(filename, encoding="utf-8") as file:
        return load_str(file.read(), filename, default_namespace, verbose)


def load_str(
    str: str, filename: str, default_namespace: str | None = None, verbose: bool = False
) -> list[tuple[Any, str]]:
    """Return the documents in a YAML string, each with its namespace; see `load_file`."""
    documents = []
    for document in yaml.load_all(str, yaml.SafeLoader):
        if document is None:
            continue
        namespace = default_namespace or get_ros_namespace()
        if isinstance(document, dict) and NS in document:
            namespace = ns_join(namespace, document.pop(NS))
            if verbose:
                print(f"reading parameters into namespace [{namespace}]")
        documents.append((document, namespace))
    return documents


def dump_params(filename: str | None, param: str, verbose: bool = False) -> None:
    """Write a parameter or a namespace to a YAML file or, if ``filename`` is None, to the standard output."""
    tree = get_param(param)
    if verbose:
        print_params(tree, param)
    if filename is None:
        sys.stdout.write(yaml.dump(tree))
        return
    write_atomically(filename, yaml.dump(tree))


# Parameters ----------------------------------------------------------------------------------------------------------


@_stock_errors()
def get_param(param: str) -> Any:
    """Return a parameter; raises MasterError if it is not set."""
    return get_param_server().getParam(_resolve(param))


def set_param(param: str, value: str, verbose: bool = False) -> None:
    """Set a parameter to the value in a YAML string."""
    set_param_raw(param, yaml.load(value, yaml.SafeLoader), verbose=verbose)


@_stock_errors()
def set_param_raw(param: str, value: Any, verbose: bool = False) -> None:
    """Set a parameter or, if the value is a dictionary, the parameters of a namespace one by one. An empty dictionary
    is only set if the namespace does not exist yet.

    Raises:
        OverflowError: a whole number has more than 32 bits, which XML-RPC cannot send.
    """
    if isinstance(value, dict):
        for key, item in value.items():
            set_param_raw(param if not key else ns_join(param, key), item, verbose=verbose)
        if value:
            return
    _check_integers(value)
    name, server = _resolve(param), get_param_server()
    if value == {} and server.hasParam(name) and isinstance(server.getParam(name), dict):
        return  # the namespace keeps its parameters
    server.setParam(name, value)
    if verbose:
        print(f"set parameter [{name}] to [{value}]")


def _check_integers(value: Any) -> None:
    if isinstance(value, int) and not -_INT_LIMIT <= value < _INT_LIMIT:
        raise OverflowError("int exceeds XML-RPC limits")
    for item in value.values() if isinstance(value, dict) else value if isinstance(value, (list, tuple)) else ():
        _check_integers(item)


def upload_params(ns: str, values: Any, verbose: bool = False) -> None:
    """Set the parameters of a namespace one by one; other parameters keep their values.

    Raises:
        RosParamException: `ns` is the root, and the values are not a dictionary.
        OverflowError: see `set_param_raw`.
    """
    _check_integers(values)
    if ns == GLOBALNS and not isinstance(values, dict):
        raise RosParamException("global / can only be set to a dictionary")
    if verbose:
        print_params(values, ns)
    set_param_raw(ns, values)


@_stock_errors()
def delete_param(param: str, verbose: bool = False) -> None:
    """Delete a parameter; raises MasterError if it is not set."""
    server = get_param_server()
    if param == GLOBALNS:
        for name in server.getParamNames():
            server.deleteParam(name)
    else:
        server.deleteParam(_resolve(param))
    if verbose:
        print(f"deleted parameter [{param}]")


@_stock_errors()
def list_params(ns: str) -> list[str]:
    """Return the names of all parameters in a namespace, sorted."""
    prefix = _resolve(ns).rstrip("/") + "/"
    return sorted(name for name in get_param_server().getParamNames() if name.startswith(prefix))


def print_params(params: Any, ns: str) -> None:
    """Print parameters as ``name=value``."""
    if not isinstance(params, dict):
        print(params)
        return
    for key, value in params.items():
        if isinstance(value, dict):
            print_params(value, ns_join(ns, key))
        else:
            print(f"{ns_join(ns, key)}={value}")


def yamlmain(argv: list[str] | None = None) -> None:
    """Run the tool with a command line; None for the process's own."""
    _main(NAME, argv)
