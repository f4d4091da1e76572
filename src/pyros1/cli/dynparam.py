"""``pyros1 dynparam``: the tool of dynamic_reconfigure (L200, https://wiki.ros.org/dynamic_reconfigure)."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from pyros1.cli.common import CommandError, Invocation, did_you_mean, guard_negatives, print_json, run, unguard
from pyros1.cli.usage import examples_text
from pyros1.errors import ParameterNotSetError, ServiceError, WaitTimeoutError
from pyros1.shown import one_line

if TYPE_CHECKING:
    from optparse import OptionParser

    from pyros1.node import Node

_T = TypeVar("_T")
_Verb = Callable[[Invocation], "int | None"]
_SERVICE = "/set_parameters"
_PATIENCE = 1.0
"""Seconds after which the user is told what is waited for."""
_EXAMPLES = {
    "list": {"%prog": "the nodes that can be configured while they run"},
    "get": {"%prog /camera": "all parameters of a node", "%prog --json /camera": "for programs"},
    "set": {
        "%prog /camera exposure 0.02": "one parameter; choices by their name",
        "%prog /camera \"{exposure: 0.02, auto: false}\"": "several at once",
    },
    "set_from_parameters": {"%prog /camera _exposure:=0.02": "from private parameters, for launch files"},
    "load": {"%prog /camera outdoors.yaml": "what `dump` has written, or plain YAML"},
    "dump": {"%prog /camera outdoors.yaml": "into a file"},
}  # fmt: skip


def usage(program: str) -> str:
    """The command list."""
    return f"""{program} shows and changes the parameters of nodes that use dynamic_reconfigure.

Commands:
\t{program} list\tlist nodes that can be configured
\t{program} get\tprint a node's configuration
\t{program} set\tset parameters of a node
\t{program} set_from_parameters\tset parameters of a node to the private parameters of this one
\t{program} load\tset parameters of a node from a file
\t{program} dump\twrite a node's configuration into a file

Type {program} <command> -h for more detailed usage, e.g. '{program} get -h'
"""


def main(argv: list[str]) -> int:
    """Run ``dynparam <verb> ...``; returns the exit code."""
    verbs: dict[str, _Verb] = {
        "list": list_nodes,
        "get": get,
        "set": set_values,
        "set_from_parameters": set_from_parameters,
        "load": load,
        "dump": dump,
    }
    return run("dynparam", argv, verbs, usage, usage_code=1)


# Command lines --------------------------------------------------------------------------------------------------------


def _parser(invocation: Invocation, arguments: str) -> OptionParser:
    verb = invocation.verb
    parser = invocation.parser(f"{verb} {arguments}")
    if invocation.program != invocation.stock:
        parser.format_epilog = lambda formatter: examples_text(  # type: ignore[method-assign]
            f"{invocation.program} {verb}", _EXAMPLES[verb]
        )
    return parser


def _parse(
    invocation: Invocation, arguments: str, *wanted: str, most: int | None = None, json: bool = False
) -> tuple[Any, list[str], OptionParser]:
    """Parse the words behind the verb.

    Args:
        arguments: what the usage line says.
        wanted: what each necessary argument is.
        most: how many there may be, if more than these.
        json: whether there is the option ``--json``.
    """
    parser = _parser(invocation, f"[options] {arguments}")
    parser.add_option("-t", "--timeout", type="float", help="seconds to wait for the node (default: without end)")
    if json:
        invocation.add_json(parser)
    options, words = parser.parse_args(guard_negatives(invocation.args))
    if len(words) < len(wanted):
        parser.error(f"invalid arguments. Please specify {wanted[len(words)]}")
    if len(words) > (most or len(wanted)):
        parser.error("too many arguments")
    return options, [unguard(word) for word in words], parser


def list_nodes(invocation: Invocation) -> None:
    """``dynparam list``: by their service, as everybody finds them."""
    parser = _parser(invocation, "")
    invocation.add_json(parser)
    options, _ = parser.parse_args(invocation.args)
    names = _known(invocation)
    if options.json:
        print_json(names)
    elif names:
        print(*map(one_line, names), sep="\n")


def _known(invocation: Invocation) -> list[str]:
    services = invocation.graph.state().services
    return sorted(name.removesuffix(_SERVICE) for name in services if name.endswith(_SERVICE))


def get(invocation: Invocation) -> None:
    """``dynparam get NODE``: as Python writes a dictionary, which is also YAML."""
    options, (name,), _ = _parse(invocation, "node", "a node name", json=True)
    values = None
    with invocation.open_node() as node:  # which ends quietly, and with it this block, when Ctrl-C ends the waiting
        values = Server(invocation, node, name, options.timeout).configuration()
    if values is None:
        return
    if options.json:
        print_json(values)
    else:
        print(values)


def dump(invocation: Invocation) -> int:
    """``dynparam dump NODE FILE``."""
    from pyros1.cli.dynparam_values import file_text  # noqa: PLC0415

    options, (name, path), _ = _parse(invocation, "node file", "a node name", "an output file")
    code = 0
    with invocation.open_node() as node:
        values = Server(invocation, node, name, options.timeout).configuration()
        if values is None:
            code = _refuse(invocation, f"couldn't get parameters from node {name}")
        else:
            _write(path, file_text(values))
    return code


def _write(path: str, text: str) -> None:
    try:
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise CommandError(f"cannot write [{path}]: {error.strerror}") from None


def set_values(invocation: Invocation) -> int:
    """``dynparam set NODE PARAMETER VALUE`` or ``dynparam set NODE YAML``."""
    form = "either a node name, parameter name and parameter value, or a node name and a YAML dictionary"
    options, words, parser = _parse(invocation, "node (parameter value | values)", form, form, most=3)
    name, *rest = words
    if len(rest) == 1:
        from pyros1.values import load_yaml  # noqa: PLC0415

        values = load_yaml(rest[0])
        if not isinstance(values, dict):
            parser.error(f"invalid arguments. Please specify {form}")
    else:
        values = {rest[0]: rest[1]}
    return _set(invocation, name, values, options.timeout)


def load(invocation: Invocation) -> int:
    """``dynparam load NODE FILE``."""
    from pyros1.cli.dynparam_values import read_file_text  # noqa: PLC0415

    options, (name, path), _ = _parse(invocation, "node file", "a node name", "an input file")
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise CommandError(f"cannot read [{path}]: {getattr(error, 'strerror', None) or error}") from None
    return _set(invocation, name, read_file_text(text, path), options.timeout)


def set_from_parameters(invocation: Invocation) -> int:
    """``dynparam set_from_parameters NODE``: the values are private parameters of this command's node."""
    options, (name,), _ = _parse(invocation, "node [_parameter:=value ...]", "a node name")
    code = 0
    with invocation.open_node() as node:
        try:
            values = node.params["~"]
        except ParameterNotSetError:
            values = None
        if not isinstance(values, dict) or not values:
            print("error updating parameters: no parameters found on parameter server", file=sys.stderr)
            code = _failed(invocation)
        else:
            code = _apply(invocation, node, name, values, options.timeout)
    return code


def _set(invocation: Invocation, name: str, values: dict[str, Any], timeout: float | None) -> int:
    code = 0
    with invocation.open_node() as node:
        code = _apply(invocation, node, name, values, timeout)
    return code


def _apply(invocation: Invocation, node: Node, name: str, values: dict[str, Any], timeout: float | None) -> int:
    from pyros1.cli.dynparam_values import ParameterError  # noqa: PLC0415

    try:
        Server(invocation, node, name, timeout).change(values)
    except ParameterError as error:
        return _refuse(invocation, f"error updating parameters: {error}", error.hint)
    except WaitTimeoutError as error:
        return _refuse(invocation, f"couldn't set parameters at node {name}", str(error))
    return 0


def _refuse(invocation: Invocation, text: str, hint: str = "") -> int:
    """Say why nothing was done, where the stock tool says it; what it would not say goes to stderr."""
    print(text, flush=True)
    if hint:
        print(f"{invocation.program}: {hint.strip(' ()')}", file=sys.stderr)
    return _failed(invocation)


def _failed(invocation: Invocation) -> int:
    """The stock tool ends with 0 although nothing was set; scripts should know."""
    return 0 if invocation.program == invocation.stock else 1


# The node to configure ------------------------------------------------------------------------------------------------


class Server:
    """A node that can be configured.

    Args:
        invocation: the command.
        node: of the command.
        name: of the node to configure, as the user wrote it.
        timeout: seconds to wait for anything; None or 0 waits for ever, and says so.

    Raises:
        WaitTimeoutError: the node is not there.
    """

    def __init__(self, invocation: Invocation, node: Node, name: str, timeout: float | None) -> None:
        self.name = invocation.resolve(name)
        self._node = node
        self._timeout = timeout or None
        service = self.name + _SERVICE
        known = _known(invocation)
        hint = "" if self.name in known else did_you_mean(self.name, known)
        self._await(lambda seconds: node.wait_for_service(service, seconds), f"service {service}", hint)

    def _await(self, wait: Callable[[float | None], _T], what: str, hint: str = "") -> _T:
        if self._timeout is not None:
            try:
                return wait(self._timeout)
            except WaitTimeoutError as error:
                raise WaitTimeoutError(f"{error}{hint}") from None
        try:
            return wait(_PATIENCE)
        except WaitTimeoutError:
            print(f"Waiting for {what}...{hint}", file=sys.stderr, flush=True)
            return wait(None)

    def _message(self, topic: str, type_name: str, what: str) -> Any:
        """The latched message of one of the node's topics."""
        full = f"{self.name}/{topic}"
        return self._await(lambda seconds: self._node.wait_for_message(full, type_name, seconds), what)

    def _description(self) -> Any:
        return self._message("parameter_descriptions", "dynamic_reconfigure/ConfigDescription", "description")

    def _config(self) -> Any:
        return self._message("parameter_updates", "dynamic_reconfigure/Config", "configuration")

    def configuration(self) -> dict[str, Any] | None:
        """Return the values of all parameters and groups; None if the node does not tell them in time."""
        from pyros1.cli.dynparam_values import configuration  # noqa: PLC0415

        try:
            description = self._description()
            return configuration(self._config(), description)
        except WaitTimeoutError:
            return None

    def change(self, values: dict[str, Any]) -> None:
        """Set parameters.

        Args:
            values: parameter -> value, ``groups`` -> group -> state.

        Raises:
            ParameterError: there is no such parameter, or it cannot have the value.
            WaitTimeoutError: the node does not describe its parameters in time.
            CommandError: the node refused.
        """
        from pyros1.cli.dynparam_values import request  # noqa: PLC0415
        from pyros1.msgs import load_service  # noqa: PLC0415
        from pyros1.msgs.fill import fill_message  # noqa: PLC0415

        fields = request(values, self._description(), self._config() if "groups" in values else None)
        service_class = load_service("dynamic_reconfigure/Reconfigure")
        message = service_class._request_class()
        fill_message(message, {"config": fields})
        try:
            self._node.service(self.name + _SERVICE, service_class).call(message, self._timeout)
        except ServiceError as error:
            raise CommandError(f"the node [{self.name}] did not change its configuration: {error}") from None
