"""``topic list``, ``info``, ``type`` and ``find``: what the master knows of topics."""

from __future__ import annotations

from pyros1.cli.common import CommandError, Invocation, did_you_mean, fail, print_json
from pyros1.graph import Graph, SystemState, in_namespace
from pyros1.net.hosts import parse_uri

_UNKNOWN = "unknown type"


def list_topics(invocation: Invocation) -> int | None:
    """``topic list [/namespace]`` (L25-L27)."""
    namespace, verbose, by_host, only, json = None, False, False, "", False
    if invocation.args:
        parser = invocation.parser("list [/namespace]")
        parser.add_option("-b", "--bag", dest="bag", help="list topics in .bag file", metavar="BAGFILE")
        invocation.add_chunk_limit(parser)
        parser.add_option("-v", "--verbose", action="store_true", help="list full details about each topic")
        parser.add_option("-p", action="store_true", dest="publishers", help="list only publishers")
        parser.add_option("-s", action="store_true", dest="subscribers", help="list only subscribers")
        parser.add_option("--host", action="store_true", help="group by host name")
        invocation.add_json(parser, "print a JSON list of objects: topic, type, publishers, subscribers")
        options, args = parser.parse_args(invocation.args)
        if len(args) > 1:
            parser.error("you may only specify one input topic")
        if options.bag:
            for given, option in ((options.subscribers, "-s"), (options.publishers, "-p"), (options.host, "--host")):
                if given:
                    parser.error(f"{option} option is not valid with bags")
            from pyros1.cli import topic_bag  # noqa: PLC0415 - bags are not cheap

            namespace = invocation.resolve(args[0]) if args else None
            topic_bag.list_topics(options.bag, namespace, json=options.json)
            return None
        if options.publishers and options.subscribers:
            parser.error("you may only specify one of -p, -s")
        namespace = invocation.resolve(args[0]) if args else None
        verbose, by_host, json = bool(options.verbose), bool(options.host), options.json
        only = "p" if options.publishers else "s" if options.subscribers else ""
    elif invocation.namespace != "/":
        namespace = None  # as stock: only a given argument narrows the list
    graph = invocation.graph
    state = graph.state()
    publishers = {} if only == "s" else _below(state.publishers, namespace)
    subscribers = {} if only == "p" else _below(state.subscribers, namespace)
    if json:
        print_json(_as_json(publishers, subscribers, graph.topic_types()))
    elif by_host:
        _list_by_host(graph, state, publishers, subscribers, verbose, only)
    elif verbose:
        print(_verbose(publishers, subscribers, graph.topic_types(), only, ""))
    else:
        print(*sorted({*publishers, *subscribers}), sep="\n")
    return None


def _as_json(
    publishers: dict[str, list[str]], subscribers: dict[str, list[str]], types: dict[str, str]
) -> list[dict[str, object]]:
    return [
        {
            "topic": topic,
            "type": types.get(topic),
            "publishers": publishers.get(topic, []),
            "subscribers": subscribers.get(topic, []),
        }
        for topic in sorted({*publishers, *subscribers})
    ]


def _below(table: dict[str, list[str]], namespace: str | None) -> dict[str, list[str]]:
    return {name: table[name] for name in in_namespace(table, namespace)}


def _verbose(
    publishers: dict[str, list[str]], subscribers: dict[str, list[str]], types: dict[str, str], only: str, indent: str
) -> str:
    lines = [""]
    for title, what, table, skip in (
        ("Published", "publisher", publishers, "s"),
        ("Subscribed", "subscriber", subscribers, "p"),
    ):
        if only == skip:
            continue
        lines.append(f"{indent}{title} topics:")
        for topic, nodes in table.items():
            plural = "s" if len(nodes) > 1 else ""
            lines.append(f"{indent} * {topic} [{types.get(topic, _UNKNOWN)}] {len(nodes)} {what}{plural}")
        lines.append(indent)
    if indent:
        lines[-1] = ""
    return "\n".join(lines)


def _list_by_host(
    graph: Graph,
    state: SystemState,
    publishers: dict[str, list[str]],
    subscribers: dict[str, list[str]],
    verbose: bool,
    only: str,
) -> None:
    hosts: dict[str, str | None] = {}
    for node in state.nodes():
        uri = graph.node_uri(node)
        hosts[node] = parse_uri(uri)[0] if uri else None
    types = graph.topic_types() if verbose else {}

    def on(host: str, table: dict[str, list[str]]) -> dict[str, list[str]]:
        here = {topic: [node for node in nodes if hosts.get(node) == host] for topic, nodes in table.items()}
        return {topic: nodes for topic, nodes in here.items() if nodes}

    for host in sorted({host for host in hosts.values() if host}):
        published, subscribed = on(host, publishers), on(host, subscribers)
        if not published and not subscribed:
            continue
        print(f"Host [{host}]:")
        if verbose:
            print(_verbose(published, subscribed, types, only, "  "))
        else:
            print("\n".join(f"  {topic}" for topic in sorted({*published, *subscribed})))


def info(invocation: Invocation) -> int | None:
    """``topic info /topic`` (L28)."""
    parser = invocation.parser("info /topic")
    invocation.add_json(parser)
    options, args = parser.parse_args(invocation.args)
    if not args:
        parser.error("you must specify a topic name")
    if len(args) > 1:
        parser.error("you may only specify one topic name")
    topic = invocation.resolve(args[0])
    graph = invocation.graph
    state = graph.state()
    publishers, subscribers = state.publishers.get(topic), state.subscribers.get(topic)
    if publishers is None and subscribers is None:
        raise CommandError(f"Unknown topic {topic}{did_you_mean(topic, {*state.publishers, *state.subscribers})}")
    if options.json:
        print_json(
            {
                "topic": topic,
                "type": graph.topic_types().get(topic),
                "publishers": [{"node": node, "uri": graph.node_uri(node)} for node in publishers or []],
                "subscribers": [{"node": node, "uri": graph.node_uri(node)} for node in subscribers or []],
            }
        )
        return None
    print(f"Type: {graph.topic_types().get(topic, _UNKNOWN)}\n")
    for title, nodes in (("Publishers", publishers), ("Subscribers", subscribers)):
        if nodes:
            print(f"{title}: ")
            for node in nodes:
                print(f" * {node} ({graph.node_uri(node) or f'unknown address {node}'})")
        else:
            print(f"{title}: None")
        print()
    print()
    return None


def type_of(invocation: Invocation) -> int | None:
    """``topic type /topic/or/field`` (L29)."""
    parser = invocation.parser("type topic_or_field")
    args = parser.parse_args(invocation.args)[1]
    if not args:
        parser.error("the following arguments are required: topic_or_field")
    if len(args) > 1:
        parser.error(f"unrecognized arguments: {' '.join(args[1:])}")
    name = invocation.resolve(args[0])
    graph = invocation.graph
    found = graph.find_topic(name)
    if found is None:
        fail(f"unknown topic type [{name}]{did_you_mean(name, graph.topic_types())}")
    _, topic_type, rest = found
    if not rest:
        print(topic_type)
        return None
    from pyros1.cli.fields import FieldPath, FieldPathError  # noqa: PLC0415 - needs the message classes
    from pyros1.errors import MessageError  # noqa: PLC0415
    from pyros1.msgs import load_message  # noqa: PLC0415

    try:
        field_type = FieldPath(rest).type_in(load_message(topic_type))
    except (FieldPathError, MessageError):
        fail(f"unknown topic type [{name}]")
    print(topic_type, rest.lstrip("/"), field_type)
    return None


def find(invocation: Invocation) -> int | None:
    """``topic find package/Type`` (L30)."""
    parser = invocation.parser("find msg-type")
    invocation.add_json(parser)
    like = "also topics whose name or type holds the word, or is spelt nearly so"
    parser.add_option("--like", metavar="WORD", help=like if invocation.program != invocation.stock else "SUPPRESSHELP")
    options, args = parser.parse_args(invocation.args)
    if not args and options.like is None:
        parser.error("please specify a message type")
    if len(args) > 1:
        parser.error("you may only specify one message type")
    types = invocation.graph.topic_types()
    names = [topic for topic, topic_type in types.items() if args and topic_type == args[0]]
    if options.like is not None:
        names += [name for name in _like(options.like, types) if name not in names]
    if options.json:
        print_json([{"topic": topic, "type": types[topic]} for topic in names])
    else:
        print(*names, sep="\n")
    return None


def _like(word: str, types: dict[str, str]) -> list[str]:
    """Topics that a word may mean, the surest first: it is in the name, in the type, or is spelt nearly as a part."""
    from difflib import get_close_matches  # noqa: PLC0415

    low = word.lower().strip("/")
    names = sorted(types)
    found = [name for name in names if low in name.lower()]
    found += [name for name in names if low in types[name].lower()]
    for name in names:
        parts = [part.lower() for part in (*name.split("/"), *types[name].split("/")) if part]
        if get_close_matches(low, parts, 1, 0.7):
            found.append(name)
    return list(dict.fromkeys(found))
