"""``service call``: calls a service and prints the response (L78)."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

from pyros1.cli.commands.service._provider import ERROR_CODE, load_type, provider_header, unavailable_error
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.parsing import parse_with_negative_numbers
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.ground.errors import MessageError, SerializationError, ServiceError, ServiceUnavailableError
from pyros1.ground.terminal_text import json_text, lines

if TYPE_CHECKING:
    from pyros1.msgs import Message, Service


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Call a service with the request in the arguments, or with each document on stdin, and print the responses."""
    if not args:
        raise UsageError("service must be specified")
    name, *values = args
    name = invocation.resolve(name)
    from pyros1.values import load_yaml  # noqa: PLC0415 - not needed for help

    arguments: list[Any] = [load_yaml(value) if value else value for value in values]
    graph = invocation.graph
    graph.service_uri(name)  # fail before slow imports if no master is running
    with invocation.open_node() as node:
        if options.wait:
            node.wait_for_service(name)
        header = provider_header(invocation, graph, name)
        if header is None:
            raise unavailable_error(graph, name)
        service_class = load_type(header.get("type", ""))
        client = node.service(name, service_class)
        if arguments or not service_class._request_class.__slots__ or sys.stdin.isatty():
            print(
                _format_response(
                    options, _call_service(client, service_class, name, arguments, node.now(), options.verbose)
                )
            )
            return
        from pyros1.cli.shared.documents import read_documents  # noqa: PLC0415 - as above

        for document in read_documents(sys.stdin):
            arguments = document if isinstance(document, list) else [document]
            response = _call_service(client, service_class, name, arguments, node.now(), options.verbose)
            print(_format_response(options, response), flush=True)


VERB = Verb(
    "call",
    "call the service with the provided args",
    Flag("-v", dest="verbose", help="print verbose output"),
    Flag("--wait", help="wait for service to be advertised"),
    Flag("--nostr", help="exclude strings", pyros1_only=True),
    Flag("--noarr", help="exclude arrays", pyros1_only=True),
    Flag("--json", help="print the response as a line of JSON", pyros1_only=True),
    Argument("/service", "service"),
    Argument("args", "request_template", optional=True),
    usage="/service [args...]",
    examples=[("/flip true", "give values in field order"), ("/flip 'data: true'", "give values by name")],
    parse=parse_with_negative_numbers,
    run=run,
)


def _format_response(options: Any, response: Message) -> str:
    if options.json:
        import json  # noqa: PLC0415

        from pyros1.msgs.json_form import to_json  # noqa: PLC0415

        return json_text(json.dumps(to_json(response), ensure_ascii=False))
    from pyros1.msgs.text import format_message  # noqa: PLC0415

    return lines(format_message(response, no_string=options.nostr, no_array=options.noarr))


def _call_service(
    client: Any, service_class: type[Service], name: str, arguments: list[Any], now: Any, verbose: bool
) -> Message:
    from pyros1.cli.shared.argument_names import argument_names  # noqa: PLC0415
    from pyros1.msgs.fill import fill_message  # noqa: PLC0415

    request = service_class._request_class()
    try:
        fill_message(request, arguments, now)
    except MessageError as error:
        given_arguments = "\n".join(f" * {argument} (type {type(argument).__name__})" for argument in arguments)
        argument_list = " ".join(argument_names(service_class._request_class))
        raise CommandError(
            f"Incompatible arguments to call service:\n{error}\nProvided arguments are:\n{given_arguments}\n\n"
            f"Service arguments are: [{argument_list}]",
            ERROR_CODE,
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
            ERROR_CODE,
        ) from None
    except ServiceUnavailableError:
        raise CommandError(f"Service [{name}] is not available.", ERROR_CODE) from None
    except ServiceError as error:
        reason = str(error)
        prefix = f"service [{name}] responded with an error: "
        if reason.startswith(prefix):
            reason = f"{prefix}{reason[len(prefix) :].encode()!r}"
        raise CommandError(reason, ERROR_CODE) from None
    return response


def _without_comments(text: str) -> str:
    lines = [line if "=" in line.partition("#")[0] else line.partition("#")[0].rstrip() for line in text.splitlines()]
    return "\n".join(line for line in lines if line)
