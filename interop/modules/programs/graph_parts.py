"""The parts of rosgraph that tools make themselves: edges, a graph of nodes, servers of XML-RPC, files of logs."""

import contextlib
import http.client
import io
import logging
import os
import re
import socket
import sys
import tempfile
import threading
import warnings
import xmlrpc.client

warnings.simplefilter("ignore")
import rosgraph
import rosgraph.impl.graph as graph
import rosgraph.network
import rosgraph.roslogging as roslogging
import rosgraph.xmlrpc as rpc

HOME = os.path.realpath(tempfile.mkdtemp())
URI = "http://localhost:1/"


def clean(value):
    text = re.sub(r"'\d{2,5}'|:\d{4,5}\b", "PORT", str(value).replace(HOME, "HOME"))
    return re.sub(r"\b(localhost|127\.0\.0\.1)\b", "HOST", re.sub(r"-\d+\.log", "-PID.log", text))


def t(title, call):
    try:
        value = call()
        print(title, type(value).__name__, clean(repr(value)))
    except Exception as error:
        print(title, "raised", [each.__name__ for each in type(error).__mro__[:2]], clean(error))


# Edges
for arguments in (("a", "b"), ("a", "b", "t"), ("", ""), ("a", "a", "t")):
    edge = graph.Edge(*arguments)
    print(
        edge,
        edge.start,
        edge.end,
        edge.label,
        edge.key,
        edge.rkey,
        edge == graph.Edge("a", "b"),
        edge != graph.Edge("a", "b", "x"),
    )
t("numbers", lambda: graph.Edge(1, 2, 3).key)
t("few", lambda: graph.Edge("a"))
for direction in ("i", "o", "b", "x", "", None):
    t("edge_args", lambda: graph.edge_args("a", "b", direction, "t"))
t("edge_args", lambda: graph.edge_args(start="a", dest="b", direction="b", label=""))
for name in (" /t", "/t", "", " ", None):
    t("node_topic", lambda: graph.node_topic(name))
    t("topic_node", lambda: graph.topic_node(name))


def show(edges):
    print(sorted((str(each), each.label) for each in edges))
    print(sorted((key, sorted(map(str, value))) for key, value in edges.edges_by_start.items() if value))
    print(sorted((key, sorted(map(str, value))) for key, value in edges.edges_by_end.items() if value))


edges = graph.EdgeList()
show(edges)
for direction in ("o", "i", "b", "x", "b"):
    t("add_edges", lambda: bool(edges.add_edges("/a", "/b", direction, "/t")))
    show(edges)
t("add_edges", lambda: bool(edges.add_edges("/a", "/c", "o")))
t("add", lambda: bool(edges.add(graph.Edge("/a", "/d", "x"))))
t("add", lambda: bool(edges.add(graph.Edge("/a", "/d", "x"))))
t("add", lambda: bool(edges.add(graph.Edge("/a", "/d", "y"))))
t("has", lambda: bool(edges.has(graph.Edge("/a", "/d", "x"))))
t("has", lambda: bool(edges.has(graph.Edge("/d", "/a", "x"))))
t("in", lambda: graph.Edge("/a", "/d", "x") in edges)
show(edges)
t("delete", lambda: edges.delete(graph.Edge("/a", "/d", "x")))
t("delete", lambda: edges.delete(graph.Edge("/no", "/d", "x")))
show(edges)
for node in ("/a", "/a", "/no", "/b", ""):
    t("delete_all", lambda: edges.delete_all(node))
    show(edges)
bad = graph.BadNode("/n", graph.BadNode.DEAD, "no answer")
print(bad.name, bad.type, bad.reason, graph.BadNode.DEAD, graph.BadNode.WONKY)
bad = graph.BadNode(name="/n", type=graph.BadNode.WONKY, reason=None)
print(bad.name, bad.type, bad.reason)


# A graph: a node that answers, one that is dead, one that answers with errors
class Handler(rpc.XmlRpcHandler):
    def getBusInfo(self, caller):
        return 1, "", []

    def getPid(self, caller):
        return 1, "", 3

    def echo(self, value):
        return value

    def fail(self):
        raise ValueError("as it should")

    def _hidden(self):
        return 1

    def _ready(self, uri):
        print("ready", clean(uri))
        ready.set()

    def _shutdown(self, reason):
        print("shutdown", reason)


class Odd(Handler):
    def getBusInfo(self, caller):
        return -1, "no", 0


ready = threading.Event()
nodes = []
for handler in (Handler(), Odd()):
    ready.clear()
    nodes.append(rpc.XmlRpcNode(rpc_handler=handler))
    nodes[-1].start()
    assert ready.wait(10)
with socket.socket() as listener:
    listener.bind(("127.0.0.1", 0))
    dead = f"http://127.0.0.1:{listener.getsockname()[1]}/"
uris = {"/graph_parts_good": nodes[0].uri, "/graph_parts_odd": nodes[1].uri, "/graph_parts_dead": dead}
for name, uri in uris.items():
    rosgraph.Master(name).registerPublisher("/graph_parts" + name[12:], "std_msgs/String", uri)
    rosgraph.Master(name).registerService("/graph_parts/service" + name[12:], "rosrpc://localhost:1", uri)
master = rosgraph.Master("/graph_parts_tool")
print([pair for pair in master.getTopicTypes() if "graph_parts" in pair[0]], sorted(master.getTopicTypes()[0])[:0])
print(clean(master.getUri()), master.getUri() == os.environ["ROS_MASTER_URI"] or clean(master.getUri()))
found = graph.Graph("/graph_parts", "/graph_parts")
print(
    found.bad_nodes,
    found.nn_nodes,
    found.nt_nodes,
    found.srvs,
    found.node_ns,
    found.topic_ns,
    found.major_version if hasattr(found, "major_version") else "",
)
found.update()
print(sorted(found.nn_nodes), sorted(found.nt_nodes), [name for name in sorted(found.srvs) if "graph_parts" in name])
print(sorted(each.label for each in found.nt_edges), list(found.nn_edges))
print(sorted((name, bad.name) for name, bad in found.bad_nodes.items() if "odd" not in name))
for name, uri in uris.items():
    rosgraph.Master(name).unregisterPublisher("/graph_parts" + name[12:], uri)
    rosgraph.Master(name).unregisterService("/graph_parts/service" + name[12:], "rosrpc://localhost:1")

# Servers
proxy = xmlrpc.client.ServerProxy(nodes[0].uri)
t("echo", lambda: proxy.echo([1, "a", {"b": True}]))
t("fail", lambda: proxy.fail())
t("hidden", lambda: proxy._hidden())
t("no such", lambda: proxy.no_such())
t("too many", lambda: proxy.getPid())
calls = xmlrpc.client.MultiCall(proxy)
calls.getPid("/a")
calls.echo(3)
t("multicall", lambda: list(calls()))
nodes[0].set_uri("http://elsewhere:1/")
print(nodes[0].uri, nodes[0].is_shutdown, type(nodes[0].server).__name__, nodes[0].port > 0)
for node in nodes:
    node.shutdown("the end")
    print(node.is_shutdown, node.server, node.handler)
errors = []
taken = socket.socket()
taken.bind(("", 0))
taken.listen()
taken_port = str(taken.getsockname()[1])
failing = rpc.XmlRpcNode(taken_port, Handler(), on_run_error=lambda error: errors.append(type(error).__name__))
with contextlib.redirect_stdout(io.StringIO()) as said:
    failing.run()
print(said.getvalue().replace(taken_port, "PORT"), errors, type(failing.port).__name__, failing.uri)
taken.close()
for kind in (rpc.ThreadingXMLRPCServer, rpc.ForkingXMLRPCServer):
    for shown in (False, True):
        server = kind(("127.0.0.1", 0), log_requests=shown)
        server.register_function(lambda value: value * 2, "double")
        said = sys.stderr = io.StringIO()
        thread = threading.Thread(target=lambda: [server.handle_request() for _ in range(1)])
        thread.start()
        client = http.client.HTTPConnection("127.0.0.1", server.server_address[1], timeout=10)
        client.request("POST", "/RPC2", xmlrpc.client.dumps((4,), "double"), {"Connection": "close"})
        print(kind.__name__, xmlrpc.client.loads(client.getresponse().read())[0], server.logRequests)
        print(getattr(server, "daemon_threads", None))
        client.close()
        thread.join(10)
        server.server_close()
        sys.stderr = sys.__stderr__
        print(thread.is_alive(), "POST" in said.getvalue() if kind is rpc.ThreadingXMLRPCServer else "")
print(rpc.SilenceableXMLRPCRequestHandler.protocol_version)


class Silent(rpc.SilenceableXMLRPCRequestHandler):
    def __init__(self, server):
        self.server = server
        self.client_address = ("1.2.3.4", 5)


class Server:
    logRequests = False


for shown in (False, True):
    Server.logRequests = shown
    said = sys.stderr = io.StringIO()
    Silent(Server()).log_message("%s and %s", "one", 2)
    sys.stderr = sys.__stderr__
    print(said.getvalue()[:8], said.getvalue().rstrip().endswith("one and 2"))
server = rpc.ThreadingXMLRPCServer(("127.0.0.1", 0))
for error in (BrokenPipeError(32, "gone"), ConnectionResetError(104, "gone")):
    try:
        raise error
    except OSError:
        print(server.handle_error(None, ("1.2.3.4", 5)))
server.server_close()

for data in (b"", b"\x00", b"\x00\x00\x00\x00", b"\x09\x00\x00\x00a"):
    try:
        print(rosgraph.network.decode_ros_handshake_header(data))
    except rosgraph.network.ROSHandshakeException as error:
        print("not a header", error)
    except Exception as error:
        print(type(error).__name__)

# Folders of logs
print(roslogging.ROS_LOG_DIR, [each.__name__ for each in roslogging.LoggingException.__mro__][:2])
os.mkdir(HOME + "/base", 0o750)
t("made", lambda: roslogging.makedirs_with_parent_perms(HOME + "/base/b/c"))
t("again", lambda: roslogging.makedirs_with_parent_perms(HOME + "/base/b/c"))
print(oct(os.stat(HOME + "/base/b/c").st_mode))
open(HOME + "/file", "w").close()
t("file", lambda: roslogging.makedirs_with_parent_perms(HOME + "/file/x"))
t("empty", lambda: roslogging.makedirs_with_parent_perms(""))
for name in ("one", "two"):
    os.mkdir(f"{HOME}/base/{name}")
    t("renew", lambda: roslogging.renew_latest_logdir(f"{HOME}/base/{name}"))
    print(clean(os.readlink(HOME + "/base/latest")))
os.remove(HOME + "/base/latest")
os.mkdir(HOME + "/base/latest")
t("folder", lambda: roslogging.renew_latest_logdir(HOME + "/base/one"))
t("gone", lambda: roslogging.renew_latest_logdir(HOME + "/no/such"))
t("in the way", lambda: roslogging.configure_logging("x", env={"ROS_LOG_DIR": HOME + "/file"}))
t("refused", lambda: roslogging.configure_logging("x", env={"ROS_LOG_DIR": HOME + "/file/logs"}))
t("nothing", lambda: roslogging.configure_logging("", env={"ROS_LOG_DIR": HOME + "/logs"}))
t("None", lambda: roslogging.configure_logging(None, env={"ROS_LOG_DIR": HOME + "/logs"}))
print([(type(each).__name__, each.level) for each in logging.getLogger().handlers], logging.getLogger().level)

# Lines of logs
record = logging.LogRecord("my.name", logging.WARNING, "/a/b.py", 12, "%s and %d", ("one", 2), None, "function")
FORMATS = (
    "${severity} ${message} ${logger} ${file} ${line} ${function} ${node} $x ${no} ${severity}",
    "",
    "${message}",
    None,
)
for form in FORMATS:
    if form is None:
        os.environ.pop("ROSCONSOLE_FORMAT", None)
    else:
        os.environ["ROSCONSOLE_FORMAT"] = form
    for level in (logging.DEBUG, logging.INFO, logging.WARNING, logging.ERROR, logging.CRITICAL):
        record.levelno, record.levelname = level, logging.getLevelName(level)
        for color in (True, False):
            out, err = io.StringIO(), io.StringIO()
            out.isatty = err.isatty = lambda: True
            roslogging.RosStreamHandler(color, out, err).emit(record)
            pattern = r"\d{10}\.\d+"
            print(level, ascii(re.sub(pattern, "TIME", out.getvalue())), ascii(re.sub(pattern, "TIME", err.getvalue())))
try:
    raise ValueError("inner")
except ValueError:
    out, err = io.StringIO(), io.StringIO()
    failed = logging.LogRecord("n", logging.ERROR, "/a/b.py", 12, "text", None, sys.exc_info(), "f")
    roslogging.RosStreamHandler(False, out, err).emit(failed)
    print("ValueError: inner" in err.getvalue(), err.getvalue().count("\n"), ascii(out.getvalue()))
