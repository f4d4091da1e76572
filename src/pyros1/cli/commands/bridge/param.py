"""``bridge param``: reads parameters of another site."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Option, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground.errors import Error, ServiceError
from pyros1.ground.terminal_text import one_line

_TIMEOUT = 15.0


def run(invocation: Invocation, options: Any, args: list[str]) -> int | None:
    """Print another site's parameter, or the names of all readable ones, or copy a parameter to this master."""
    from pyros1.bridge.names import SiteNameError, check_site_name  # noqa: PLC0415
    from pyros1.bridge.parameters import (  # noqa: PLC0415
        ROS2_SITE,
        ParameterError,
        ParameterRequest,
        check_name,
        decode_parameter_request,
        encode_parameter_request,
    )

    if not 1 <= len(args) <= 2:
        raise UsageError("name a site, such as red:, and a parameter")
    site, _, rest = args[0].partition(":")
    name = rest or (args[1] if len(args) == 2 else "")
    request = ParameterRequest(site, f"/{name.lstrip('/')}" if name else "")
    try:
        check_site_name(site)
        decode_parameter_request(encode_parameter_request(request))
        if site != ROS2_SITE:
            check_name(request)
    except (SiteNameError, ParameterError) as error:
        raise CommandError(str(error), 2) from None
    if rest and len(args) == 2:
        raise UsageError("too many arguments")
    if options.to and not name:
        raise UsageError("--to needs a parameter of the other site")
    value = _ask(invocation, request)
    if not name:
        names = [one_line(each) for each in value] if isinstance(value, list) else []
        print_json(names) if options.json else print("".join(f"{each}\n" for each in names), end="")
    elif options.to:
        from pyros1.cli.commands.param._leaves import set_leaves  # noqa: PLC0415

        set_leaves(invocation, invocation.resolve(options.to), value)
    else:
        _print(value, options.json)
    return None


def _print(value: Any, as_json: bool) -> None:
    from pyros1.cli.commands.param.get import as_json as to_json  # noqa: PLC0415
    from pyros1.cli.commands.param.get import yaml_text  # noqa: PLC0415

    if as_json:
        print_json(to_json(value))
    else:
        print(yaml_text(value))


def _ask(invocation: Invocation, request: Any) -> Any:
    """Return a site's answer through the first bridge of this master that gets one.

    Raises:
        CommandError: no bridge gets an answer.
    """
    from pyros1.bridge.local_graph import find_bridges  # noqa: PLC0415
    from pyros1.bridge.parameters import PARAMETER_SERVICE, decode_parameter_response, encode_parameter_request  # noqa: PLC0415
    from pyros1.bridge.service_ends import PARAMETERS_CLASS  # noqa: PLC0415
    from pyros1.msgs import AnyMsg  # noqa: PLC0415

    bridges = sorted(find_bridges(invocation.graph.state()))
    if not bridges:
        raise CommandError("no bridge is running on this master; start one with: pyros1 bridge --site NAME ...")
    problems = []
    with invocation.open_node() as node:
        for bridge in bridges:
            client = node.service(f"{bridge}/{PARAMETER_SERVICE}", PARAMETERS_CLASS)
            try:
                return decode_parameter_response(client.call(AnyMsg(encode_parameter_request(request)), _TIMEOUT)._buff)
            except ServiceError as error:
                text = str(error) if error.answer is None else error.answer.decode("utf-8", "replace")
                problems.append(text)
            except Error as error:
                problems.append(str(error))
    unknown = f"there is no site {request.site}"
    raise CommandError(one_line(next((text for text in problems if text != unknown), unknown), 1000))


VERB = Verb(
    "param",
    "read parameters of another site, if it lets others read them",
    Option("--to", metavar="NAME", help="copy it to this parameter on this master instead of printing it"),
    JSON_FLAG,
    Argument("site", help="the site: red:"),
    Argument("parameter", optional=True, help="without it, the names of all readable parameters are printed"),
    description="Print a parameter of another site's master as YAML. The bridges of both sites must be running, and "
    "the other site must allow it with --params. While `pyros1 bridge ros2` runs, the site `ros2:` is "
    "ROS 2. Without a parameter, the names of its nodes are printed; with the name of a node, all of its parameters.",
    examples=[
        ("red:", "the parameters of site red that may be read"),
        ("red: /robot_description --to /red/robot_description", "copy one to this master, for rviz"),
        ("ros2: /controller/gains.p", "a parameter of a ROS 2 node"),
    ],
    stock="",
    run=run,
)
