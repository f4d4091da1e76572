"""Names in the modules that have them, where programs seldom look: constants, times, names, manifests, generators."""

import os
import re
import sys
import warnings

warnings.simplefilter("ignore")
import genmsg.base
import genmsg.msg_loader
import genmsg.msgs
import genpy.generator
import genpy.rostime
import roslib.launcher
import roslib.msgs
import roslib.network
import roslib.packages
import roslib.rosenv
import roslib.srvs
import rosbag.bag
import rosgraph.impl.graph
import rosgraph.names
import rosgraph.network
import rosgraph.rosenv
import rosgraph.xmlrpc
import rospkg
import rospy.core
import rospy.exceptions
import rospy.impl.paramserver
import rospy.impl.tcpros_base
import rospy.names
import rospy.service
import rospy.topics
import tf2_py
from dynamic_reconfigure import parameter_generator, parameter_generator_catkin


def t(title, call):
    try:
        print(title, repr(call()))
    except Exception as error:
        print(title, "raised", type(error).__name__)


# Constants
for module in (rospy.core, rospy.service, rospy.topics):
    print(module.ANYTYPE, module.GLOBALNS, module.REMAP, module.ROSRPC, module.SEP, module.SERVICE_ANYTYPE)
    print(module.TOPIC_ANYTYPE, module.MASTER_NAME)
print(rospy.names.ANYTYPE, rospy.names.GLOBALNS, rospy.names.REMAP, rospy.names.SEP, rospy.names.SERVICE_ANYTYPE)
print(
    rospy.names.TOPIC_ANYTYPE,
    rospy.impl.tcpros_base.TCPROS,
    rospy.impl.tcpros_base.BIDIRECTIONAL,
    rospy.impl.tcpros_base.DEFAULT_BUFF_SIZE,
)
print(rospy.service.BIDIRECTIONAL, rospy.topics.DEFAULT_BUFF_SIZE, rospy.impl.paramserver.GLOBALNS)
print(rospy.client.DEBUG, rospy.client.INFO, rospy.client.ERROR, rospy.client.FATAL, rospy.client.TIMEOUT_READY)
print(rospy.FATAL, rospy.impl.paramserver.SEP)
print(genmsg.DURATION, genmsg.TIME, genmsg.HEADER, genmsg.EXT_MSG, genmsg.EXT_SRV, genmsg.SEP)
print(genmsg.MSG_DIR, genmsg.SRV_DIR, genmsg.base.EXT_MSG, genmsg.base.EXT_SRV, genmsg.base.SEP)
print(genmsg.base.COMMENTCHAR, genmsg.base.CONSTCHAR, genmsg.base.IODELIM, genmsg.base.MSG_DIR, genmsg.base.SRV_DIR)
for module in (genmsg.msgs, genmsg.msg_loader):
    print(module.DURATION, module.TIME, module.DURATION_MSG.split(), module.TIME_MSG.split(), module.HEADER)
    print(module.HEADER_FULL_NAME, module.EXT_MSG, module.SEP)
print(genmsg.msgs.MSG_DIR, genmsg.msg_loader.COMMENTCHAR, genmsg.msg_loader.CONSTCHAR, genmsg.msg_loader.IODELIM)
print(genmsg.msg_loader.EXT_SRV, sorted(genpy.generator.SIMPLE_TYPES))
print(roslib.msgs.COMMENTCHAR, roslib.msgs.CONSTCHAR, roslib.msgs.DURATION, roslib.msgs.TIME, roslib.msgs.HEADER)
print(roslib.msgs.EXT, roslib.msgs.SEP)
print(roslib.srvs.COMMENTCHAR, roslib.srvs.EXT, roslib.srvs.IODELIM, roslib.srvs.SEP)
print(roslib.packages.ROS_PACKAGE_PATH, roslib.packages.ROS_ROOT, roslib.network.ROS_HOSTNAME)
print(roslib.rosenv.ROS_HOME, roslib.rosenv.ROS_HOSTNAME, roslib.rosenv.ROS_MASTER_URI, roslib.rosenv.ROS_ROOT)
print(roslib.rosenv.ROS_PACKAGE_PATH)
for module in (rosgraph, rosgraph.rosenv):
    print(module.ROS_HOSTNAME, module.ROS_IP, module.ROS_IPV6, module.ROS_MASTER_URI)
print(rosgraph.network.ROS_HOSTNAME, rosgraph.network.ROS_IP, rosgraph.network.ROS_IPV6)
print(rosgraph.xmlrpc.ThreadingXMLRPCServer.daemon_threads, rosgraph.impl.graph.logger.name)
compression = rosbag.bag.Compression
print(compression.NONE, compression.BZ2, compression.LZ4)

# Exceptions: what catches what
for kind, texts in (
    (rospy.exceptions.ROSException, ("a",)),
    (rospy.exceptions.ROSInitException, ("a", "b")),
    (rospy.exceptions.ROSInternalException, ()),
    (rospy.exceptions.ROSInterruptException, ("a",)),
    (rospy.exceptions.ROSSerializationException, ("a",)),
    (rospy.exceptions.TransportException, ("a",)),
    (rospy.ROSInternalException, ("a",)),
    (rospy.ROSSerializationException, ("a",)),
    (rospy.TransportException, ("a",)),
    (genmsg.base.MsgGenerationException, ("a",)),
    (tf2_py.ConnectivityException, ("a",)),
    (tf2_py.InvalidArgumentException, ("a",)),
    (rosbag.bag.ROSBagEncryptException, ("a",)),
    (rosbag.bag.ROSBagEncryptNotSupportedException, ("a",)),
):
    error = kind(*texts)
    print(kind.__name__, str(error), error.args, isinstance(error, KeyboardInterrupt), isinstance(error, KeyError))
    print(isinstance(error, (rospy.exceptions.ROSException, rospy.exceptions.ROSInternalException)))
print(
    issubclass(tf2_py.ConnectivityException, tf2_py.TransformException),
    issubclass(tf2_py.InvalidArgumentException, ValueError),
)

# Times
for kind in (genpy.rostime.TVal, genpy.rostime.Time, genpy.rostime.Duration):
    one = kind(2, 3)
    one.secs, one.nsecs = one.secs + 1, one.nsecs + 2 * 10**9
    print(one.canon(), one.secs, one.nsecs, one.to_nsec(), one.is_zero(), kind().is_zero())
print(rospy.rostime.Time().is_zero(), rospy.rostime.Duration(0, 1).is_zero())

# Names
CASES = [
    "",
    "/",
    "a",
    "/a",
    "~a",
    "~",
    "a/b",
    "/a/b/",
    "a//b",
    "a-b",
    "1a",
    "_a",
    "a.b",
    "a b",
    "~/a",
    "a:=b",
    ":=",
    "\xe4",
]
for case in CASES:
    t(case, lambda: rosgraph.names.canonicalize_name(case))
    t(case, lambda: (rosgraph.names.is_global(case), rosgraph.names.is_private(case)))
    t(case, lambda: (bool(rosgraph.names.is_legal_name(case)), bool(rosgraph.names.is_legal_base_name(case))))
    t(case, lambda: (bool(rosgraph.names.is_legal_remap(case)), rosgraph.names.make_global_ns(case)))
    t(case, lambda: rosgraph.names.namespace(case))
os.environ["ROS_NAMESPACE"] = "over"
t("caller", lambda: rosgraph.names.make_caller_id("me"))
t("none", lambda: (rosgraph.names.is_legal_name(None), rosgraph.names.is_legal_base_name(None)))
t("none", lambda: rosgraph.names.namespace(None))

# Manifests
other = rospkg.Manifest()
print(
    other.author,
    other.brief,
    other.description,
    other.filename,
    other.license_url,
    other.licenses,
    other.status,
    other.url,
)
before = list(sys.path)
t("load", lambda: roslib.launcher.load_manifest("std_msgs"))
print(sys.path == before)

# Descriptions of parameters, under both names of the module; stock's looks at the command line
sys.argv[1:] = ["share", "package", "include", "python"]


def refused(title, call):
    """The kinds of some errors are only stock's."""
    try:
        print(title, call())
    except Exception:
        print(title, "refused")


for generator in (parameter_generator, parameter_generator_catkin):
    print(generator.LINEDEBUG, generator.bool_t, generator.double_t, generator.int_t, generator.str_t, generator.id)
    refused("quotes", lambda: generator.check_description('a "b"'))
    for name in ("a", "a_1", "1a", "", "a b", "a-b", "\xe4"):
        refused(name, lambda: generator.check_name(name))
    gen = generator.ParameterGenerator()
    print(gen.minval["int"], gen.maxval["int"], gen.defval)
    print([gen.pytype(each).__name__ for each in ("str", "int", "double", "bool")])
    t("type", lambda: gen.pytype("float"))
    small = gen.const("Small", "int", 1, "a small one")
    large = gen.const("Large", "int", 2, "a large one")
    t("const", lambda: gen.const("Wrong", "int", "x", "wrong"))
    t("const", lambda: gen.const("Wrong", "int", 1.5, "wrong"))
    size = gen.enum([small, large], "sizes")
    print(size.count("'name'"), size.count("small"))
    t("enum", lambda: gen.enum([small, gen.const("Word", "str", "x", "y")], "mixed"))
    t("add", lambda: gen.add("size", "int", 1, "its size", 1, 0, 3, edit_method=size))
    t("add", lambda: gen.add("rate", "double", 2, "its rate", 5, 0, 9))
    t("add", lambda: gen.add("wrong", "double", 2, "its rate", "x"))
    group = gen.add_group("A Group", type="tab", state=False)
    t("group", lambda: group.add("on", "bool", 4, "whether", True))
    t("group", lambda: isinstance(group, gen.Group))
    for param in (
        {"name": "p", "type": "int", "v": 3},
        {"name": "p", "type": "double", "v": 3},
        {"name": "p", "type": "int", "v": "x"},
    ):
        t("check", lambda: (gen.check_type(param, "v"), param["v"]))
        t("fill", lambda: (gen.fill_type(param), param["ctype"], param["cconsttype"]))
        t("default", lambda: (gen.check_type_fill_default(param, "v", 7), param["v"]))
        param["v"] = None
        t("default", lambda: (gen.check_type_fill_default(param, "v", 7), param["v"]))
    tree = gen.group.to_dict()
    print(
        [
            (each["name"], each["type"], each["default"], each["min"], each["max"], each["level"])
            for each in tree["parameters"]
        ]
    )
    print([(each["name"], each["type"], each["state"], len(each["parameters"])) for each in tree["groups"]])
