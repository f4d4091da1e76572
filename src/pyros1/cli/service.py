"""``pyros1 service``: rosservice (L76-L79)."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

from pyros1.cli.common import CommandError, Invocation, did_you_mean, fail, guard_negatives, print_json, run, unguard
from pyros1.errors import (
    DefinitionError,
    MasterError,
    MessageError,
    SerializationError,
    ServiceError,
    ServiceUnavailableError,
    UnknownTypeError,
)
from pyros1.graph import PROBE_TIMEOUT, Graph, in_namespace, probe_service
from pyros1.shown import json_text, lines

if TYPE_CHECKING:
    from optparse import Values

    from pyros1.msgs import Message, Service

_ERROR = 2
"""Exit code of errors, other than of most tools."""


def usage(program: str) -> str:
    """The command list."""
    return f"""Commands:
\t{program} args\tprint service arguments
\t{program} call\tcall the service with the provided args
\t{program} find\tfind services by service type
\t{program} info\tprint information about service
\t{program} list\tlist active services
\t{program} type\tprint service type
\t{program} uri\tprint service ROSRPC uri

Type {program} <command> -h for more detailed usage, e.g. '{program} call -h'
"""


def _service_argument(invocation: Invocation, *, json: bool = False) -> tuple[str, bool]:
    """The service's full name, and whether JSON was asked for, which ``json`` allows."""
    parser = invocation.parser(f"{invocation.verb} /service")
    if json:
        invocation.add_json(parser)
    options, args = parser.parse_args(invocation.args)
    if not args:
        parser.error("you must specify a service name" if invocation.verb == "info" else "service must be specified")
    if len(args) > 1:
        parser.error(
            "you may only specify one service"
            if invocation.verb == "info"
            else "you may only specify one input service"
        )
    return invocation.resolve(args[0]), json and options.json


def _hint(graph: Graph, name: str) -> str:
    return did_you_mean(name, graph.state().services)


def _header(invocation: Invocation, graph: Graph, name: str) -> dict[str, str] | None:
    """The connection header of the service's provider; None if nobody provides the service."""
    uri = graph.service_uri(name)
    if uri is None:
        return None
    try:
        return probe_service(name, uri, invocation.caller_id)
    except ServiceUnavailableError as error:
        text = f"Unable to communicate with service [{name}], address [{uri}]"
        if isinstance(error.__cause__, TimeoutError):
            who = ", ".join(graph.state().services.get(name, ["its node"]))
            text += f"\n{who} takes connections, but did not answer within 5 s: was it stopped?"
        raise CommandError(text, _ERROR) from None


def list_services(invocation: Invocation) -> None:
    """``service list [/namespace]`` (L76)."""
    namespace, with_nodes, json = None, False, False
    if invocation.args:
        parser = invocation.parser("list [/namespace]")
        parser.add_option("-n", "--nodes", action="store_true", help="print nodes that provide service(s)")
        invocation.add_json(parser)
        options, args = parser.parse_args(invocation.args)
        if len(args) > 1:
            parser.error("you may only specify one input namespace")
        namespace = invocation.resolve(args[0]) if args else None
        with_nodes, json = bool(options.nodes), options.json
    services = invocation.graph.state().services
    if json:
        names = sorted(in_namespace(services, namespace))
        print_json([{"service": name, "nodes": services[name]} for name in names])
        return
    for name in sorted(in_namespace(services, namespace)):
        print(f"{name} {','.join(map(str, services[name]))}" if with_nodes else name)


def info(invocation: Invocation) -> None:
    """``service info /service`` (L76)."""
    name, json = _service_argument(invocation, json=True)
    graph = invocation.graph
    nodes = graph.state().services.get(name)
    if not nodes:
        raise CommandError(f"unknown service{_hint(graph, name)}", 1)
    if not json:  # line by line: what is known is shown although the provider may not answer
        print(f"Node: {nodes[0]}")
        print(f"URI: {graph.service_uri(name)}")
    type_name = (_header(invocation, graph, name) or {}).get("type", "")
    if json:
        arguments = list(_load(type_name)._request_class.__slots__)
        print_json(
            {"service": name, "node": nodes[0], "uri": graph.service_uri(name), "type": type_name, "args": arguments}
        )
        return
    print(f"Type: {type_name}")
    print(f"Args: {' '.join(_load(type_name)._request_class.__slots__)}")


def type_of(invocation: Invocation) -> None:
    """``service type /service`` (L77)."""
    name, _ = _service_argument(invocation)
    header = _header(invocation, invocation.graph, name)
    if header is None:
        fail(f"Unknown service [{name}]{_hint(invocation.graph, name)}")
    print(header.get("type", ""))


def uri(invocation: Invocation) -> None:
    """``service uri /service`` (L77)."""
    name, _ = _service_argument(invocation)
    found = invocation.graph.service_uri(name)
    if found is None:
        fail(f"Unknown service: {name}{_hint(invocation.graph, name)}")
    print(found)


def node(invocation: Invocation) -> None:
    """``service node /service`` (L77)."""
    name, _ = _service_argument(invocation)
    services = invocation.graph.state().services
    nodes = services.get(name)
    if not nodes:
        fail(f"Unknown service: {name}{did_you_mean(name, services)}")
    print(nodes[0])


def args_of(invocation: Invocation) -> None:
    """``service args /service`` (L77)."""
    name, _ = _service_argument(invocation)
    header = _header(invocation, invocation.graph, name)
    if header is None:
        raise CommandError(f"Service [{name}] is not available.{_hint(invocation.graph, name)}", _ERROR)
    print(" ".join(_load(header.get("type", ""))._request_class.__slots__))


def find(invocation: Invocation) -> None:
    """``service find package/Type``: asks the provider of every service (L77)."""
    parser = invocation.parser("find msg-type")
    invocation.add_json(parser)
    options, args = parser.parse_args(invocation.args)
    if not args:
        parser.error("please specify a message type")
    if len(args) > 1:
        parser.error("you may only specify one message type")
    graph = invocation.graph
    from pyros1.doctor.together import together  # noqa: PLC0415 - the other verbs ask one provider

    names = list(graph.state().services)
    answers = together({name: partial(_header, invocation, graph, name) for name in names}, PROBE_TIMEOUT + 1.0)
    matching = []
    said: set[str] = set()
    for name, header in answers.items():
        if isinstance(header, dict):
            if header.get("type") == args[0]:
                matching.append(name)
        elif isinstance(header, MasterError):
            raise header
        elif header is not None:  # it does not answer for its type
            what, _, why = str(header).partition("\n")  # why: once for all services of a node
            print(f"WARNING: {what}" + (f"\n{why}" if why and why not in said else ""), file=sys.stderr)
            said.add(why)
    if options.json:
        print_json(matching)
    else:
        print(*matching, sep="\n")


def call(invocation: Invocation) -> None:
    """``service call /service [args...]`` (L78)."""
    parser = invocation.parser("call /service [args...]")
    parser.add_option("-v", dest="verbose", action="store_true", help="print verbose output")
    parser.add_option("--wait", action="store_true", help="wait for service to be advertised")
    shown = invocation.program != invocation.stock
    parser.add_option("--nostr", action="store_true", help="exclude strings" if shown else "SUPPRESSHELP")
    parser.add_option("--noarr", action="store_true", help="exclude arrays" if shown else "SUPPRESSHELP")
    invocation.add_json(parser, "print the response as a line of JSON")
    options, words = parser.parse_args(guard_negatives(invocation.args))
    if not words:
        parser.error("service must be specified")
    name, *words = map(unguard, words)
    name = invocation.resolve(name)
    from pyros1.values import load_yaml  # noqa: PLC0415

    arguments: list[Any] = [load_yaml(word) if word else word for word in words]
    graph = invocation.graph
    graph.service_uri(name)  # before anything is imported: is there a master?
    with invocation.open_node() as node:
        if options.wait:
            node.wait_for_service(name)
        header = _header(invocation, graph, name)
        if header is None:
            raise CommandError(f"Service [{name}] is not available.{_hint(graph, name)}", _ERROR)
        service_class = _load(header.get("type", ""))
        client = node.service(name, service_class)
        if arguments or not service_class._request_class.__slots__ or sys.stdin.isatty():
            print(_response(options, _call(client, service_class, name, arguments, node.now(), bool(options.verbose))))
            return
        for document in stdin_documents():
            response = _call(client, service_class, name, _as_arguments(document), node.now(), bool(options.verbose))
            print(_response(options, response), flush=True)


def _response(options: Values, response: Message) -> str:
    if options.json:
        import json  # noqa: PLC0415

        from pyros1.msgs.json_form import to_json  # noqa: PLC0415

        return json_text(json.dumps(to_json(response), ensure_ascii=False))
    from pyros1.msgs.text import format_message  # noqa: PLC0415

    return lines(format_message(response, no_string=bool(options.nostr), no_array=bool(options.noarr)))


def stdin_documents() -> Iterator[Any]:
    """The YAML documents on stdin, each as soon as its ``---`` or the end is there."""
    from pyros1.cli.shared.documents import documents  # noqa: PLC0415

    return documents(sys.stdin)


def _as_arguments(document: Any) -> list[Any]:
    return document if isinstance(document, list) else [document]


def _call(
    client: Any, service_class: type[Service], name: str, arguments: list[Any], now: Any, verbose: bool
) -> Message:
    from pyros1.cli.shared.argument_names import argument_names  # noqa: PLC0415
    from pyros1.msgs.fill import fill_message  # noqa: PLC0415

    request = service_class._request_class()
    try:
        fill_message(request, arguments, now)
    except MessageError as error:
        provided = "\n".join(f" * {argument} (type {type(argument).__name__})" for argument in arguments)
        expected = " ".join(argument_names(service_class._request_class))
        raise CommandError(
            f"Incompatible arguments to call service:\n{error}\nProvided arguments are:\n{provided}\n\n"
            f"Service arguments are: [{expected}]",
            _ERROR,
        ) from None
    if verbose:
        print(f"{request}\n---")
    sys.stdout.flush()
    try:
        response: Message = client.call(request)
    except SerializationError as error:
        raise CommandError(
            "Unable to send request. One of the fields has an incorrect type:\n"
            f"  {error}\n\nsrv file:\n{_without_comments(service_class._full_text)}\n",
            _ERROR,
        ) from None
    except ServiceUnavailableError:
        raise CommandError(f"Service [{name}] is not available.", _ERROR) from None
    except ServiceError as error:
        reason = str(error)
        prefix = f"service [{name}] responded with an error: "
        if reason.startswith(prefix):
            reason = f"{prefix}{reason[len(prefix) :].encode()!r}"
        raise CommandError(reason, _ERROR) from None
    return response


def _without_comments(text: str) -> str:
    lines = [line if "=" in line.partition("#")[0] else line.partition("#")[0].rstrip() for line in text.splitlines()]
    return "\n".join(line for line in lines if line)


def _load(type_name: str) -> type[Service]:
    from pyros1.msgs import load_service  # noqa: PLC0415

    try:
        return load_service(type_name)
    except (UnknownTypeError, DefinitionError) as error:
        raise CommandError(f"Unable to load type [{type_name}]: {error}", _ERROR) from None


_VERBS = {
    "list": list_services,
    "info": info,
    "type": type_of,
    "uri": uri,
    "node": node,
    "args": args_of,
    "find": find,
    "call": call,
}


def main(argv: list[str]) -> int:
    """Run ``service <verb> ...``; returns the exit code."""
    return run("rosservice", argv, _VERBS, usage, error_code=_ERROR)
