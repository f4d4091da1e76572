"""Names of which libraries make several topics and services, with random remappings: stock's beside ours.

roscpp's libraries resolve and remap such a name first (a NodeHandle of that name) and then each topic's; so do those of
`pyros1`. rospy's do not: they remap the topic's name alone, and actionlib applies remappings that are written exactly
as the action's name. The modules under stock's names do as these.
"""

from __future__ import annotations

import random
import subprocess
from collections.abc import Sequence

import pytest
from faces import run, same
from harness import INTEROP, Master

MASTERS = ("ours",)
NAMES_PEER = INTEROP / "build" / "names_peer"
TOPICS = {
    "action_server": ("goal", "cancel", "status", "feedback", "result"),
    "simple_server": ("goal", "cancel", "status", "feedback", "result"),
    "action_client": ("goal", "cancel", "status", "feedback", "result"),
    "simple_client": ("goal", "cancel", "status", "feedback", "result"),
    "buffer_client": ("goal", "cancel", "status", "result"),
    "reconfigure_server": ("parameter_descriptions", "parameter_updates", "set_parameters"),
    "filter": (),
}
"""What is composed from the name; each kind of object also gets names of its own, so that no two types meet."""
OF_ROSPY = {**TOPICS, "markers": ("update", "update_full", "feedback"), "publisher": (), "subscriber": (), "remap": ()}
OF_ROSCPP = {**TOPICS, "buffer_server": ("goal", "cancel", "status", "feedback", "result")}


def random_words(chance: random.Random, kinds: dict[str, Sequence[str]]) -> tuple[list[str], list[str]]:
    """Return lines `KIND NAME` and a command line with remappings of those names, and of what is composed of them."""
    lines, remappings = [], {}
    for number, (kind, composed) in enumerate(kinds.items()):
        names = [f"k{number}{letter}" for letter in "abc"]
        given = [_form(chance, name) for name in names]
        for count in range(chance.randrange(2, 5)):
            old = chance.choice((chance.choice(given), _form(chance, chance.choice(names))))
            if composed and chance.random() < 0.4:
                old += "/" + chance.choice(composed)
            new = chance.choice(names) if chance.random() < 0.2 and "/k" not in old else f"k{number}x{count}"
            remappings[old] = _form(chance, new)
        lines += [f"{kind} {name}{chance.choice(('', '', '/'))}" for name in given]
    arguments = [f"{old}:={new}" for old, new in remappings.items()]
    chance.shuffle(arguments)
    return lines, [*arguments, *chance.choice(([], ["__ns:=/ns"], ["__ns:=ns/inner", "__name:=other"]))]


def _form(chance: random.Random, name: str) -> str:
    return chance.choice((name, name, f"/{name}", f"~{name}", f"ns/{name}", f"/ns/{name}", f"in_{name}/{name}"))


COMMON = """
import os, sys, xmlrpc.client
def serve(uri, me, end, kinds):
    node = xmlrpc.client.ServerProxy(uri)
    def registered():
        return {f"pub {n}" for n, _ in node.getPublications(me)[2]} | {f"sub {n}" for n, _ in node.getSubscriptions(me)[2]}
    kept, before = [], registered()
    for line in sys.argv[1].splitlines():
        kind, _, name = line.partition(" ")
        try:
            made, services = kinds[kind](name)
        except Exception as error:
            print("made: refused", type(error).__name__)
            continue
        now = registered()
        print("made:", *sorted(now - before), *(f"srv {service}" for service in services))
        if hasattr(made, "close"):
            made.close()
        else:
            kept, before = [*kept, made], now
    sys.stdout.flush()
    end()  # other tests have the same master
    os._exit(0)  # not waiting for timers
"""

ROSPY = (
    COMMON
    + """
import types
import rospy, actionlib, tf2_ros, message_filters, dynamic_reconfigure.server
from actionlib.msg import TestAction
from dynamic_reconfigure.parameter_generator_catkin import ParameterGenerator, int_t
from interactive_markers.interactive_marker_server import InteractiveMarkerServer
from std_msgs.msg import String
generator = ParameterGenerator()
generator.add("number", int_t, 0, "A number", 1, 0, 5)
one = lambda value: {"number": value}
config = types.SimpleNamespace(config_description=generator.group.to_dict(), min=one(0), max=one(5), defaults=one(1),
                               level=one(0), type=one("int"), all_level=0)
rospy.init_node("names")
def started(server):
    server.start()
    return server, ()
def client_of_buffer(name):
    client = tf2_ros.BufferClient(name)
    if hasattr(client.client, "action_client"):
        client.client.action_client.feedback_sub.unregister()  # ours has none: servers send nothing there
    return client, ()
def reconfigured(name):
    server = dynamic_reconfigure.server.Server(config, lambda values, level: values, name)
    parameters = [name for name in rospy.get_param_names() if name.endswith("/number")]
    for name in parameters:
        rospy.get_master().deleteParam(name)
    return server, (server.set_service.resolved_name, *sorted(parameters))
serve(rospy.get_node_uri(), rospy.get_name(), lambda: rospy.signal_shutdown("done"), {
    "action_server": lambda name: started(actionlib.ActionServer(name, TestAction, print, auto_start=False)),
    "simple_server": lambda name: started(actionlib.SimpleActionServer(name, TestAction, print, auto_start=False)),
    "action_client": lambda name: (actionlib.ActionClient(name, TestAction), ()),
    "simple_client": lambda name: (actionlib.SimpleActionClient(name, TestAction), ()),
    "buffer_client": client_of_buffer,
    "reconfigure_server": reconfigured,
    "filter": lambda name: (message_filters.Subscriber(name, String), ()),
    "markers": lambda name: (InteractiveMarkerServer(name), ()),
    "publisher": lambda name: (rospy.Publisher(name, String, queue_size=1), ()),
    "subscriber": lambda name: (rospy.Subscriber(name, String), ()),
    "remap": lambda name: (0, (rospy.remap_name(name), rospy.remap_name(name, "/o/n"), rospy.resolve_name(name))),
})
"""
)

PYROS1 = (
    COMMON
    + """
import pyros1
from pyros1 import actions, filters, reconfigure, tf
node = pyros1.Node("names_peer")
parameters = reconfigure.Parameters()
parameters.add("number", 1, "A number")
buffer = tf.Buffer()
def reconfigured(name):
    name = name if name[0] in "~/" else node.resolve(name, remap=False)
    server = reconfigure.Server(node, parameters, lambda values, level: values, name)
    return server, (server.service.name,)
serve(node.uri, node.name, node.shutdown, {
    "action_server": lambda name: (actions.Server(node, name, "actionlib/Test", print), ()),
    "simple_server": lambda name: (actions.SimpleServer(node, name, "actionlib/Test", print), ()),
    "action_client": lambda name: (actions.Client(node, name, "actionlib/Test"), ()),
    "simple_client": lambda name: (actions.Client(node, name, "actionlib/Test"), ()),
    "buffer_client": lambda name: (tf.BufferClient(node, name), ()),
    "buffer_server": lambda name: (tf.BufferServer(node, buffer, name), ()),
    "reconfigure_server": reconfigured,
    "filter": lambda name: (filters.Subscriber(node, name, "std_msgs/String"), ()),
})
"""
)


@pytest.mark.parametrize("seed", range(4))
def test_modules_under_stocks_names_compose_as_stocks(master: Master, seed: int) -> None:
    lines, arguments = random_words(random.Random(seed), OF_ROSPY)
    same(master, ROSPY, "\n".join(lines), *arguments)


@pytest.mark.parametrize("seed", range(4))
def test_our_own_libraries_compose_as_those_of_roscpp(master: Master, seed: int) -> None:
    lines, arguments = random_words(random.Random(100 + seed), OF_ROSCPP)
    # A NodeHandle's functions refuse private names, where ours resolve them as everywhere.
    lines = [line if line.startswith("reconfigure_server") else line.replace("~", "") for line in lines]
    done = subprocess.run(
        [NAMES_PEER, *arguments],
        input="".join(f"{line}\n" for line in lines),
        env=master.environ("stock"),
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    stock, ours = _made(done.stdout), _made(run("ours", master, PYROS1, "\n".join(lines), *arguments))
    assert len(stock) == len(ours) == len(lines)
    for line, mine, theirs in zip(lines, ours, stock, strict=True):
        if line.startswith("buffer_client"):  # ours does not ask for feedback: servers of transforms send none
            assert mine == {each for each in theirs if not each.endswith("/feedback")}, line
            continue
        assert mine == theirs, f"{line} {' '.join(arguments)}"


def _made(printed: str) -> list[set[str]]:
    """Return the names in each line that is not a log message."""
    lines = [line.split()[1:] for line in printed.splitlines() if line.startswith("made:")]
    return [{" ".join(words[at : at + 2]) for at in range(0, len(words), 2)} for words in lines]
