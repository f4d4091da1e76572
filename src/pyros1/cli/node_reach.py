"""The verbs of ``pyros1 node`` that contact nodes: ``ping``, ``kill`` and ``cleanup`` (L73-L75)."""

from __future__ import annotations

import itertools
import sys
import time
from functools import partial

from pyros1.cli.common import MASTER_TIMEOUT, CommandError, Invocation, did_you_mean
from pyros1.errors import DeadlineError, Error, MasterError, UnknownHostError
from pyros1.graph import Graph
from pyros1.net.hosts import parse_uri

_PING_TIMEOUT = 3.0


def ping(invocation: Invocation) -> None:
    """``node ping [node]`` (L73)."""
    parser = invocation.parser("ping [options] <node>")
    parser.add_option("-a", "--all", action="store_true", help="ping all nodes")
    parser.add_option(
        "-c", type="int", dest="count", metavar="COUNT", help="number of pings to send. Not available with --all"
    )
    options, args = parser.parse_args(invocation.args)
    graph = invocation.graph
    if options.all:
        names = graph.state().nodes()
        print("Will ping the following nodes: \n" + "".join(f" * {name}\n" for name in names))
        for name in names:
            _ping(graph, name, 1)
        return
    if not args:
        try:
            available = "\n".join(map(str, sorted(graph.state().nodes())))
        except Error:
            available = ""
        parser.print_usage(sys.stderr)
        hint = f"Please enter a node to ping. Available nodes are:\n{available}\n" if available else ""
        if hint:
            print(f"\n{invocation.program}: error: {hint}".lstrip("\n"), end="", file=sys.stderr)
        parser.error("Please enter a node to ping")
    if len(args) > 1:
        parser.error("you may only specify one input node")
    name = invocation.resolve(args[0])
    print(f"{invocation.program}: node is [{name}]")
    _ping(graph, name, options.count, forever=True)


def _ping(graph: Graph, name: str, count: int | None, forever: bool = False) -> bool:
    """Ping a node; errors end it. ``forever``: as the command for one node does, with pauses and an average."""
    uri = graph.node_uri(name)
    if uri is None:
        sys.stdout.flush()
        print(f"cannot ping [{name}]: unknown node", file=sys.stderr)
        return False
    print(f"pinging {name} with a timeout of {_PING_TIMEOUT}s")
    total, done = 0.0, 0
    node = graph.node(uri, _PING_TIMEOUT)
    try:
        for number in itertools.count(1):
            milliseconds = node.ping() * 1000.0
            print(f"xmlrpc reply from {uri}\ttime={milliseconds:f}ms", flush=True)
            total, done = total + milliseconds, number
            if count is not None and number >= count:
                break
            time.sleep(1.0)
    except KeyboardInterrupt:
        pass
    except Error as error:
        sys.stdout.flush()
        print(f"ERROR: {_ping_failure(error, name, uri)}", file=sys.stderr)
        return False
    finally:
        node.close()
    if forever and done > 1:
        print(f"ping average: {total / done:f}ms")
    return True


def _ping_failure(error: Error, name: str, uri: str) -> str:
    cause = error.__cause__
    if isinstance(error, UnknownHostError):
        return f"Unknown host [{parse_uri(uri)[0]}] for node [{name}]"
    if isinstance(error, DeadlineError):
        return f"connection to [{uri}] timed out"
    if isinstance(cause, ConnectionRefusedError):
        return f"connection refused to [{uri}]"
    return f"communicating with [{uri}]: {error}"


def kill(invocation: Invocation) -> int:
    """``node kill [node]...`` (L74)."""
    parser = invocation.parser("kill [node]...")
    parser.add_option("-a", "--all", action="store_true", help="kill all nodes")
    options, args = parser.parse_args(invocation.args)
    if options.all and args:
        parser.error("invalid arguments with kill all (-a) option")
    graph = invocation.graph
    known = graph.state().nodes()
    if options.all:
        names = known
    elif args:
        names = [invocation.resolve(arg) for arg in args]
        unknown = [name for name in names if name not in known]
        if unknown:
            raise CommandError(
                "Unknown node(s):\n" + "\n".join(f" * {name}{did_you_mean(name, known)}" for name in unknown)
            )
    else:
        chosen = _choose(sorted(known))
        if chosen is None:
            return 0
        names = [chosen]
    if len(names) > 1:
        print("killing:\n" + "\n".join(f" * {name}" for name in names))
    else:
        print(f"killing {names[0]}" if names else "killing:")
    failed = [name for name in names if not _kill(graph, name)]
    if failed:
        sys.stdout.flush()
        print("ERROR: Failed to kill:\n" + "\n".join(f" * {name}" for name in failed), file=sys.stderr)
        return 1
    print("killed")
    return 0


def _choose(names: list[str]) -> str | None:
    """Let the user choose a node by its number; None if there is none, or no answer."""
    if not names:
        print("No nodes running")
        return None
    print("".join(f"{number}. {name}\n" for number, name in enumerate(names, 1)))
    print("Please enter the number of the node you wish to kill.\n> ", end="", flush=True)
    while True:
        line = sys.stdin.readline()
        if not line:
            return None
        if line.strip().isdecimal() and 1 <= int(line) <= len(names):
            return names[int(line) - 1]
        print("ERROR: please enter a number (ctrl-C to cancel)", flush=True)


def _kill(graph: Graph, name: str) -> bool:
    uri = graph.node_uri(name)
    if uri is None:
        return False
    node = graph.node(uri)
    try:
        node.shutdown("user request")
    except DeadlineError as error:
        print(f"[{name}]: {error}; kill -9 ends a process that hangs", file=sys.stderr)
        return False
    except Error:
        # A node may end before it has answered, and a dead one needs no killing: stock says killed in both cases.
        return True
    finally:
        node.close()
    return True


def cleanup(invocation: Invocation) -> None:
    """``node cleanup`` (L75)."""
    parser = invocation.parser("cleanup")
    if parser.parse_args(invocation.args)[1]:
        parser.error("too many arguments")
    graph = invocation.graph
    from pyros1.doctor.together import together  # noqa: PLC0415 - the other verbs ask one node

    names = graph.state().nodes()
    answers = together({name: partial(_answers, graph, name) for name in names}, _PING_TIMEOUT + 1.0)
    for found in answers.values():
        if isinstance(found, MasterError):
            raise found  # not known to be dead
    dead = [name for name, answers_us in answers.items() if answers_us is not True]
    if not dead:
        return
    print("Unable to contact the following nodes:\n" + "\n".join(f" * {name}" for name in dead))
    print("Warning: these might include alive and functioning nodes, e.g. in unstable networks.")
    print("Cleanup will purge all information about these nodes from the master.")
    print("Please type y or n to continue:", flush=True)
    while True:
        line = sys.stdin.readline()
        answer = line.strip()
        if answer == "y":
            break
        if answer == "n" or not line:
            print("aborting")
            return
        print("Please type y or n to continue:", flush=True)
    for name in dead:
        print(f"Unregistering {name}")
        _unregister(invocation, graph, name)
    print("done")


def _answers(graph: Graph, name: str) -> bool:
    uri = graph.node_uri(name)
    if uri is None:
        return True  # it went meanwhile
    node = graph.node(uri, _PING_TIMEOUT)
    try:
        node.pid()
    except Error as error:
        sys.stderr.write(f"ERROR: {_ping_failure(error, name, uri)}\n")  # in one: others are asked at the same time
        return False
    finally:
        node.close()
    return True


def _unregister(invocation: Invocation, graph: Graph, name: str) -> None:
    """Take all registrations of a node off the master, in its name."""
    from pyros1.net.master_client import MasterClient  # noqa: PLC0415

    uri = graph.node_uri(name)
    if uri is None:
        return
    node = graph.state().of_node(name)
    calls: list[tuple[str, list[str]]] = [("unregisterPublisher", [topic, uri]) for topic in node.publications]
    calls += [("unregisterSubscriber", [topic, uri]) for topic in node.subscriptions]
    for service in node.services:
        service_uri = graph.service_uri(service)
        if service_uri:
            calls.append(("unregisterService", [service, service_uri]))
    master = MasterClient(name, invocation.master.uri, timeout=MASTER_TIMEOUT)
    try:
        for method, arguments in calls:
            master.call(method, *arguments)
    finally:
        master.close()
