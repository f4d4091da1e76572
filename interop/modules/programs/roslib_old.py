"""What programs use of roslib that rospkg and rosgraph have: packages, rospack's answers, the environment, names."""

import os
import tempfile
import warnings

warnings.simplefilter("ignore")
HOME = os.path.realpath(tempfile.mkdtemp())
ROOT = os.path.join(HOME, "src")
os.environ["ROS_PACKAGE_PATH"] = ROOT
os.environ.pop("ROS_HOSTNAME", None)

import roslib
import roslib.manifest as manifest
import roslib.names as names
import roslib.network as network
import roslib.packages as packages
import roslib.rosenv as rosenv
import roslib.rospack as rospack
import roslib.scriptutil as scriptutil


def clean(value):
    return str(value).replace(HOME, "HOME")


def t(title, call):
    try:
        value = call()
        print(title, type(value).__name__, clean(repr(value)))
    except Exception as error:
        print(
            title,
            "raised",
            [each.__name__ for each in type(error).__mro__[:2]],
            clean(error).partition(": b")[0].partition(". ROS_")[0],
        )


def put(path, text, mode=0o644):
    path = os.path.join(ROOT, path)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as file:
        file.write(text)
    os.chmod(path, mode)


BASE = (
    "<license url='http://l'>B</license><author>x</author><author> y </author><description brief='b'> d </description>"
)
put("one/manifest.xml", f"<package>{BASE}<depend package='two'/><depend package='three'/></package>")
put("two/manifest.xml", f"<package>{BASE}<depend package='three'/></package>")
put("three/manifest.xml", f"<package>{BASE}<rosdep name='boost'/></package>")
put(
    "four/package.xml",
    """<package><name>four</name><version>1.0.0</version><description>d</description><license>B</license>
<maintainer email="a@b.com">A</maintainer><run_depend>two</run_depend><build_depend>three</build_depend><export><two plugin="${prefix}/p.xml"/></export>
</package>""",
)
put("wrong/manifest.xml", "<package><license>B")
put("one/nodes/run.py", "#!/usr/bin/env python3\n", 0o755)
put("one/scripts/run.py", "#!/usr/bin/env python3\n", 0o755)
put("one/scripts/data.txt", "")
put("one/msg/A.msg", "")
put("group/inner/manifest.xml", f"<package>{BASE}</package>")

# Manifests
for name in ("one", "four", "wrong"):  # on stock each call here and below starts a process
    t("file", lambda: manifest.manifest_file(name, required=False))
for name in ("one", "two", "three"):
    t("load", lambda: manifest.load_manifest(name).brief)
    t("parse", lambda: manifest.parse_file(os.path.join(ROOT, name, "manifest.xml")).author)
    t("export", lambda: manifest.load_manifest(name).get_export("a", "b"))
print(manifest.MANIFEST_FILE)

# rospack
for name in ("two",):
    for function in (
        rospack.rospack_depends,
        rospack.rospack_depends_1,
        rospack.rospack_depends_on,
        rospack.rospack_depends_on_1,
    ):
        t(f"{function.__name__} {name}", lambda: sorted(function(name)))
    t("find", lambda: rospack.rospackexec(["find", name]))
t("depends", lambda: rospack.rospack_depends("nobody"))
for arguments in (["depends1", "one"], ["no such", "one"]):
    t(arguments, lambda: rospack.rospackexec(arguments))

# Packages
for name in ("one", "nobody"):
    t("dir", lambda: packages.get_pkg_dir(name))
    t("dir", lambda: packages.get_pkg_dir(name, required=False))
    t("subdir", lambda: packages.get_pkg_subdir(name, "scripts", required=False))
    t("made", lambda: packages.get_pkg_subdir(name, "made/below"))
    t("resource", lambda: packages.resource_file(name, "msg", "A.msg"))
    t("resource", lambda: packages.resource_file(name, "no", "A.msg"))
    for node in ("run.py", "data.txt", "no", ""):
        if node:
            t("node", lambda: sorted(packages.find_node(name, node)))
            t("found", lambda: sorted(packages.find_resource(name, node)))
t("filtered", lambda: packages.find_resource("one", "run.py", lambda path: "nodes" in path))
print(os.path.isdir(os.path.join(ROOT, "one/made/below")))
for path in ("one", "one/scripts", "group", "group/inner", "", "no/such"):
    t("dir_pkg", lambda: packages.get_dir_pkg(os.path.join(ROOT, path)))
print(packages.MANIFEST_FILE, packages.PACKAGE_FILE)
for kind in (packages.ROSPkgException, packages.InvalidROSPkgException):
    print(kind.__name__, [each.__name__ for each in kind.__mro__], kind("text"))

# The environment
print(rosenv.ROS_IP, rosenv.ROS_LOG_DIR, rosenv.ROS_NAMESPACE)
NAMED = dict(
    ROS_ROOT=HOME,
    ROS_PACKAGE_PATH="/a:/b",
    ROS_MASTER_URI="http://a:1",
    ROS_LOG_DIR="/l",
    ROS_HOME="/h",
    ROS_TEST_RESULTS_DIR="/t",
)
for environ in (
    NAMED,
    {"ROS_HOME": "/h"},
    {},
    {"ROS_MASTER_URI": "", "ROS_ROOT": "", "ROS_PACKAGE_PATH": ""},
    {"ROS_ROOT": "/no/such"},
):
    for function in (rosenv.get_ros_home, rosenv.get_log_dir):
        t(function.__name__, lambda: function(environ).replace(os.path.expanduser("~"), "~"))
    for function in (rosenv.get_ros_root, rosenv.get_ros_package_path, rosenv.get_master_uri):
        if function is not rosenv.get_ros_root or rosenv.ROS_ROOT in environ:
            t(function.__name__, lambda: function(True, environ))
        t(function.__name__, lambda: function(False, environ))
    for argv in ([], ["x", "__master:=http://b:2"], ["__master:=", "__master:=http://c"]):
        t("master", lambda: rosenv.get_master_uri(True, environ, argv))

# roslib, scriptutil
for value in (True, False, 3, None):
    roslib.set_interactive(value)
    print(roslib.is_interactive())
for proxy in (scriptutil.get_master(), scriptutil.get_param_server()):
    print(type(proxy).__name__, proxy.getSystemState("/x")[0], proxy.setParam("/x", "/roslib_old", 3)[0::2])
    print(proxy.getParam("/x", "/roslib_old"), proxy.deleteParam("/x", "/roslib_old")[::2])

# Names: the same as rosgraph's, and genmsg's
print(names.ANYTYPE, names.GLOBALNS, names.PRIV_NAME, names.PRN_SEPARATOR, names.REMAP, names.SEP)
CASES = [
    "",
    "/",
    "a",
    "/a",
    "~a",
    "a/b",
    "/a/b/",
    "a//b",
    "//a",
    "a-b",
    "1a",
    "_a",
    "a.b",
    "a b",
    "/a/~b",
    "é",
    "~",
    "a/",
]
for case in CASES:
    for function in (
        names.canonicalize_name,
        names.is_global,
        names.is_legal_base_name,
        names.is_legal_name,
        names.is_legal_resource_base_name,
        names.is_private,
        names.make_global_ns,
        names.namespace,
        names.package_resource_name,
        names.resource_name_base,
        names.make_caller_id,
    ):
        t(f"{function.__name__} {case!r}", lambda: function(case))
for environ, argv in (
    ({}, []),
    ({"ROS_NAMESPACE": "a"}, []),
    ({"ROS_NAMESPACE": "/a/"}, ["__ns:=b"]),
    ({}, ["__ns:=/c"]),
    ({"ROS_NAMESPACE": ""}, ["__ns:="]),
    ({"ROS_NAMESPACE": "1/~x"}, []),
):
    t("get_ros_namespace", lambda: names.get_ros_namespace(environ, argv))
one, other = names.anonymous_name("id"), names.anonymous_name("id")
print(
    one.split("_")[0],
    one == other,
    names.is_legal_name(one),
    len(one.split("_")),
    one.split("_")[2] == str(os.getpid()),
)

# Addresses
for environ in (
    None,
    {},
    {"ROS_IP": "1.2.3.4"},
    {"ROS_HOSTNAME": "a"},
    {"ROS_IP": "1.2.3.4", "ROS_HOSTNAME": "a"},
    {"ROS_IP": "::1"},
    {"ROS_HOSTNAME": ""},
):
    for argv in ([], ["x", "__ip:=5.6.7.8"], ["__hostname:=b"], ["__ip:="]):
        t("override", lambda: network.get_address_override(environ or {}, argv))
for address in (None, "", "localhost", "127.0.0.1", "1.2.3.4"):
    t("bind", lambda: network.get_bind_address(address))
t("uri", lambda: network.create_local_xmlrpc_uri(1234))
t("uri", lambda: network.create_local_xmlrpc_uri(0))
t("uri", lambda: network.create_local_xmlrpc_uri("x"))
print(network.get_host_name(), network.ROS_IP, [each.__name__ for each in network.ROSHandshakeException.__mro__][:2])
try:
    raise network.ROSHandshakeException("text")
except Exception as error:
    print(repr(error))
