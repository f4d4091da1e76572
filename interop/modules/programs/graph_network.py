"""Names, addresses and connection headers: rosgraph."""

import rosgraph, rosgraph.names as n, rosgraph.network as w, rosgraph.rosenv as e, rosgraph.roslogging as l, sys, os, socket


def show(f):
    try:
        r = f()
        return (type(r).__name__, str(r))
    except Exception as e:
        return ("!", type(e).__name__)


for t in [
    "a",
    "/a",
    "a/b",
    "~a",
    "a/b/c",
    "",
    "/",
    "a-b",
    "1a",
    "a//b",
    "//a",
    "a/",
    "/a/b/",
    "~/a",
    "~",
    "a:=b",
    "_x:=3",
    "__n:=4",
    ":=",
    "a:=",
    "-x:=1",
    "1:=2",
    "/a:=b",
    "~a:=b",
    "a:=b:=c",
]:
    print(
        repr(t),
        [
            show(lambda: getattr(n, k)(t))
            for k in "canonicalize_name is_global is_legal_base_name is_legal_name is_private make_global_ns namespace isstring is_legal_remap make_caller_id".split()
        ],
    )
    for ns in ["/", "/x", "/x/", "x", "", "~", "/x/y"]:
        print(
            "   ",
            ns,
            show(lambda: n.ns_join(ns, t)),
            show(lambda: n.resolve_name(t, ns)),
            show(lambda: n.resolve_name(t, ns, {"/a": "/zz", "/x/a": "/yy"})),
            show(lambda: n.script_resolve_name("/q/s", t)),
        )
for argv in (["p", "a:=b", "_x:=3", "__name:=t", "y", "_:=4", "~x:=2", "f:=", "::=", "g:=1 2"], []):
    print(n.load_mappings(argv), show(lambda: rosgraph.myargv(argv)))
for env in ({}, {"ROS_NAMESPACE": "foo"}, {"ROS_NAMESPACE": "/foo/"}, {"ROS_NAMESPACE": ""}):
    print(
        show(lambda: n.get_ros_namespace(env, [])),
        show(lambda: n.get_ros_namespace(env, ["x", "__ns:=bar"])),
        show(lambda: e.get_master_uri(env, [])),
        show(lambda: e.get_master_uri(env, ["__master:=http://x:3/"])),
    )
print(
    show(lambda: e.get_master_uri({"ROS_MASTER_URI": "foo"}, [])),
    show(lambda: e.get_master_uri({"ROS_MASTER_URI": ""}, [])),
    show(lambda: e.get_master_uri({}, ["__master:="])),
    e.DEFAULT_MASTER_URI,
    e.DEFAULT_MASTER_PORT,
)
print(
    n.anonymous_name("a").startswith("a_"),
    n.ANYTYPE,
    n.GLOBALNS,
    n.MSG_EXT,
    n.SRV_EXT,
    n.PRIV_NAME,
    n.REMAP,
    n.SEP,
    n.ROS_NAMESPACE,
    n.REMAP_PATTERN.pattern,
    n.NAME_LEGAL_CHARS_P.pattern,
    n.BASE_NAME_LEGAL_CHARS_P.pattern,
)
for u in [
    "http://a:5/",
    "http://a",
    "http://a:5/x",
    "https://a:5",
    "rosrpc://a:5",
    "a:5",
    "",
    "http://[::1]:5/",
    "http://a:x",
    "http://a:80",
]:
    print(u, show(lambda: w.parse_http_host_and_port(u)))
for h in [{}, {"a": "b"}, {"a": "b=c", "d": ""}, {"b": "é"}, {"z": "1", "a": "2"}, {"a": b"x"}, 3]:
    print(
        show(lambda: w.encode_ros_handshake_header(h)),
        show(lambda: w.decode_ros_handshake_header(w.encode_ros_handshake_header(h))),
    )
for b in [
    b"",
    b"\0\0\0\0",
    b"\5\0\0\0abc",
    b"\7\0\0\0\3\0\0\0abc",
    b"\7\0\0\0\3\0\0\0a=c",
    b"\7\0\0\0\3\0\0\0a=cxx",
    b"\7\0\0\0\x09\0\0\0a=cxx",
]:
    print(b, show(lambda: w.decode_ros_handshake_header(b)))


def pair(data, size=4096):
    import io

    a, b = socket.socketpair()
    a.sendall(data)
    a.shutdown(socket.SHUT_WR)
    try:
        return w.read_ros_handshake_header(b, io.BytesIO(), size)
    finally:
        a.close()
        b.close()


for d in [w.encode_ros_handshake_header({"a": "b", "callerid": "/x"}), b"", b"\7\0\0\0"]:
    print(show(lambda: pair(d)))
a, b = socket.socketpair()
print(w.write_ros_handshake_header(a, {"x": "y"}))
print(b.recv(100))
a.close()
b.close()
print(
    w.create_local_xmlrpc_uri(5),
    w.get_host_name(),
    w.get_address_override(),
    w.get_bind_address(),
    w.get_bind_address("localhost"),
    w.get_bind_address("1.2.3.4"),
    w.use_ipv6(),
    w.is_local_address("localhost"),
    w.is_local_address("8.8.8.8"),
    w.is_local_address("127.0.0.1"),
    show(lambda: w.is_local_address("no.such.host.invalid")),
    w.get_local_address() in w.get_local_addresses(),
    "127.0.0.1" in w.get_local_addresses(),
)
for env in (
    {"ROS_HOSTNAME": "hh"},
    {"ROS_IP": "1.2.3.4"},
    {"ROS_IP": "127.0.0.1"},
    {"ROS_IPV6": "on"},
    {"ROS_HOSTNAME": "localhost"},
):
    for k in ("ROS_HOSTNAME", "ROS_IP", "ROS_IPV6"):
        os.environ.pop(k, None)
    os.environ.update(env)
    print(
        env,
        show(w.get_host_name),
        show(w.get_local_address) if "ROS_IPV6" not in env else "",
        show(w.get_address_override),
        show(w.get_bind_address),
        show(lambda: w.create_local_xmlrpc_uri(5)),
        show(w.use_ipv6),
    )
sys.argv = ["p", "a:=b", "__ip:=9.9.9.9"]
print(w.get_address_override())
sys.argv = ["p", "__hostname:=qq"]
print(w.get_address_override(), w.get_host_name())
