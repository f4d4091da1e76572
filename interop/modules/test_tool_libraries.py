"""rostopic, rosnode, rosservice, rosparam and rosmsg as libraries: stock's and ours answer the same.

Feature: `import rostopic`, `rosnode`, `rosservice`, `rosparam`, `rosmsg` as libraries -- same results, exceptions and
    signatures as stock's
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import faces
import pytest
from harness import Master, until

OWN_MASTER = True
pytestmark = pytest.mark.ours_only

SIGNATURES = """
import importlib, inspect, json
def form(function):
    return [[p.name, p.kind.name, repr(p.default)] for p in inspect.signature(function).parameters.values()]
found = {}
for name in ("rostopic", "rosnode", "rosservice", "rosparam", "rosmsg"):
    module = importlib.import_module(name)
    for key in dir(module):
        value = getattr(module, key)
        home = (getattr(value, "__module__", "") or "").partition(".")[0]
        if home != name or inspect.ismodule(value):
            continue
        if inspect.isfunction(value):
            found[name + "." + key] = form(value)
        elif inspect.isclass(value):
            found[name + "." + key] = [] if issubclass(value, Exception) else form(value.__init__)
            for member in dir(value):
                if not member.startswith("_") and inspect.isfunction(getattr(value, member)):
                    if not issubclass(value, Exception):
                        found[name + "." + key + "." + member] = form(getattr(value, member))
print(json.dumps(found))
"""

PRIVATE = (
    "rostopic._get_topic_type", "rostopic._rostopic_list_group_by_host", "rostopic._rostopic_list",
    "rostopic._rostopic_type", "rostopic._rostopic_info", "rostopic._rostopic_echo", "rostopic._rostopic_hz",
    "rostopic._rostopic_bw", "rostopic._rostopic_delay", "rostopic._check_master",
    "rostopic._master_get_topic_types", "rosnode._succeed", "rosservice._succeed",
    "rosservice._get_master", "rosservice._rosservice_list", "rosservice._rosservice_type",
    "rosservice._rosservice_uri",
    "rosservice._rosservice_node", "rosservice._rosservice_call", "rosservice._rosservice_args",
    "rosservice._rosservice_info", "rosmsg._list_types", "rosmsg._msg_filter", "rosparam._get_caller_id",
)  # fmt: skip
"""What programs reach for, though it is private."""
LEFT_OUT = {
    *(f"rostopic.{name}" for name in ("argv_publish", "create_value_transform", "file_yaml_arg", "param_publish")),
    *("rostopic.param_publish_once", "rostopic.stdin_yaml_arg", "rosmsg.construct_ordered_mapping"),
    *("rosmsg.construct_yaml_map_with_ordered_dict", "rosmsg.init_rosmsg_proto", "rosmsg.represent_ordered_mapping"),
    "rosmsg.rosmsg_cmd_prototype",
}
"""What no public program uses: an error says what ours have in its place."""
TALKER = """
import rospy
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import String
from std_srvs.srv import Empty, EmptyResponse, SetBool, SetBoolResponse
rospy.init_node("talker")
chatter = rospy.Publisher("chatter", String, queue_size=1)
poses = rospy.Publisher("pose", PoseStamped, queue_size=1)
rospy.Subscriber("heard", String, lambda message: None)
rospy.Service("flip", SetBool, lambda request: SetBoolResponse(not request.data, "done"))
rospy.Service("~nothing", Empty, lambda request: EmptyResponse())
rospy.set_param("talker_runs", True)
rate = rospy.Rate(50)
try:
    while not rospy.is_shutdown():
        message = PoseStamped()
        message.header.stamp = rospy.Time.now()
        poses.publish(message)
        chatter.publish("hello")
        rate.sleep()
except rospy.ROSInterruptException:
    pass
"""

HEAD = """
import os, re, sys
import rosgraph, rospy
def ask(function, *arguments, **named):
    try:
        print("->", re.sub(" at 0x[0-9a-f]+", "", repr(function(*arguments, **named))))
    except SystemExit as error:
        print("exit")
    except Exception as error:
        print(type(error).__module__.partition(".")[0], type(error).__name__, repr(str(error)))
    sys.stdout.flush()
master = rosgraph.Master("/asking")
"""

TOPICS = """
import rostopic
from geometry_msgs.msg import PoseArray, Pose, PoseStamped
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool, String, Time, UInt8MultiArray
for topic in ("/chatter", "chatter", "/pose/pose/position/x", "/pose/pose", "/not_there", "/heard"):
    kind, name, field = rostopic.get_topic_type(topic)
    print(kind, name, field is None, rostopic._get_topic_type(topic)[:2])
    cls, name, field = rostopic.get_topic_class(topic)
    print(cls and cls._type, name, field is None)
message = PoseStamped()
message.pose.position.x = 7
print(rostopic.get_topic_class("/pose/pose/position/x")[2](message))
print(rostopic.get_topic_class("/chatter", blocking=True)[1])
for kind in ("std_msgs/String", "std_msgs/NotThere", "wrong", "geometry_msgs/PoseStamped"):
    ask(rostopic.find_by_type, kind)
lists = rostopic.get_topic_list()
lists = [[entry for entry in table if entry[0] != "/rosout_agg"] for table in lists]
print(lists, type(rostopic.get_topic_list(master=master)))
own = [[entry for entry in table if entry[2] == ["/talker"]] for table in lists]
ask(rostopic._rostopic_list_group_by_host, master, *own)
ask(rostopic.get_info_text, "/chatter")
ask(rostopic.get_info_text, "/heard")
ask(rostopic.get_info_text, "/not_there")
ask(rostopic.get_api, master, "/talker")
ask(rostopic._check_master)
ask(rostopic._rostopic_type, "/chatter")
ask(rostopic._rostopic_info, "/chatter")
ask(rostopic._rostopic_list, "/pose")
ask(rostopic.rostopicmain, ["rostopic", "type", "/pose"])
ask(rostopic.rostopicmain, ["rostopic", "find", "geometry_msgs/PoseStamped"])
ask(rostopic.msgevalgen, "")
array = PoseArray(poses=[Pose(), Pose(), Pose()])
for number, pose in enumerate(array.poses):
    pose.position.y = number
for path in ("/poses[1]/position/y", "/poses[1:]/position/y", "/header/frame_id", "/poses[0]", "/nothing"):
    ask(rostopic.msgevalgen(path), array)
scan = LaserScan(ranges=[1, 2], range_max=3)
for flags in ((False, False), (True, False), (False, True), (True, True)):
    print([list(rostopic.create_field_filter(*flags)(each)) for each in (String("x"), scan, array.header)])
for each in (message, scan, String("a"), array, Bool(True), UInt8MultiArray(data=b"ab"), Time(rospy.Time(3, 4))):
    for fields in (None, rostopic.create_field_filter(True, True)):
        made = rostopic.CallbackEcho("/x", None, plot=True, field_filter_fn=fields)
        for _ in range(2):
            made.callback(each, {"topic": "/x", "type_information": None}, rospy.Time(5, 6))
def echo(times, *arguments, topic="/pose", **named):
    made = rostopic.CallbackEcho(*arguments, **named)
    for _ in range(times):
        made.callback(message, {"topic": topic, "type_information": None})
        print(made.done, made.count)
echo(3, "/pose", None, count=2)
echo(2, "/pose", None, plot=True)
echo(1, "/pose", rostopic.msgevalgen("/pose/position"), fixed_numeric_width=9)
echo(1, "/pose", rostopic.msgevalgen("/pose/position/x"))
echo(1, "/pose", None, filter_fn=lambda m: m.pose.position.x > 8)
echo(1, "/other", None)
echo(1, "/", None, echo_all_topics=True)
echo(1, "/pose", None, field_filter_fn=rostopic.create_field_filter(True, True), echo_clear=True)
echo(1, "/pose", None, value_transform_fn=lambda value, kind: value)
print(issubclass(rostopic.ROSTopicIOException, rostopic.ROSTopicException), rostopic.NAME, rostopic.SUBSCRIBER_TIMEOUT)
"""

RATES = """
import rostopic
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import String
rospy.init_node("observer", anonymous=True)
rates = rostopic.ROSTopicHz(20)
several = rostopic.ROSTopicHz(-1)
sizes = rostopic.ROSTopicBandwidth(30)
ages = rostopic.ROSTopicDelay(25)
none = rostopic.ROSTopicHz(5, filter_expr=lambda message: False)
counts = {}
def count(name, function, *more):
    def heard(message, *arguments):
        function(message, *more)
        counts[name] = counts.get(name, 0) + 1
    return heard
rospy.Subscriber("/chatter", rospy.AnyMsg, count("a", rates.callback_hz))
rospy.Subscriber("/chatter", rospy.AnyMsg, count("b", several.callback_hz, "/chatter"))
rospy.Subscriber("/chatter", rospy.AnyMsg, count("c", several.callback_hz, "/pose"))
rospy.Subscriber("/chatter", rospy.AnyMsg, count("d", sizes.callback))
rospy.Subscriber("/pose", PoseStamped, count("e", ages.callback_delay))
rospy.Subscriber("/chatter", rospy.AnyMsg, count("f", none.callback_hz))
deadline = rospy.get_time() + 30
while len(counts) < 6 or min(counts.values()) < 40:
    assert rospy.get_time() < deadline, counts
    rospy.sleep(0.05)
def until(reached):
    while not reached():
        assert rospy.get_time() < deadline, counts
        rospy.sleep(0.05)
def fresh(name):  # there is nothing to say again without a new message
    before = counts[name]
    until(lambda: counts[name] > before)
def rate_of(made, *topic):  # the rate of some moment in which the machine was not too busy
    found = []
    def look():
        found[:] = made.get_hz(*topic) or [0]
        return 25 < found[0] < 100
    until(look)
    return found
deadline += 30
rate, least, most, deviation, number = rate_of(rates)
print(25 < rate < 100, 0 <= least <= 1 / rate <= most, deviation >= 0, number)
rate, least, most, deviation, number = rate_of(several, "/pose")
print(25 < rate < 100, number > 30)
print(len(several.get_times("/chatter")) > 30, several.get_msg_t0("/x"))
print(several.get_msg_tn("/x"), several.get_last_printed_tn("/x"))
fresh("e")
mean, least, most, deviation, number = ages.get_delay()
print(0 <= least <= mean <= most < 5, number)
import contextlib, io
def shown(function, *arguments):
    text = io.StringIO()
    with contextlib.redirect_stdout(text):
        function(*arguments)
    print(re.sub(r"[0-9]+([.][0-9]+)?", "N", text.getvalue()))
fresh("a")
shown(rates.print_hz)
shown(sizes.print_bw)
fresh("e")
shown(ages.print_delay)
for each in (none.print_hz, rostopic.ROSTopicDelay(5).print_delay, rostopic.ROSTopicBandwidth().print_bw):
    shown(each)
print(none.get_hz(), rostopic.ROSTopicDelay(3).get_delay(), several.get_hz("/not_there"))
"""

SERVICES = """
import rosservice
for name in ("/flip", "flip", "/not_there", "/talker/nothing"):
    ask(rosservice.get_service_type, name)
    ask(rosservice.get_service_node, name)
    ask(lambda: rosservice.get_service_class_by_name(name)._type)
for name in ("/flip", "/not_there"):
    ask(rosservice.get_service_uri, name)
print(sorted(rosservice.get_service_list(node="/talker")), sorted(rosservice.get_service_list(namespace="/talker")))
print(sorted(name for name in rosservice.get_service_list() if "flip" in name))
print(rosservice.get_service_list("/not_there"))
print([each for each in rosservice.get_service_list(include_nodes=True) if "/flip" in each])
for kind in ("std_srvs/SetBool", "std_srvs/NotThere", "wrong"):
    ask(rosservice.rosservice_find, kind)
for name in ("/flip", "/talker/nothing", "/not_there"):
    ask(rosservice.get_service_args, name)
    ask(rosservice.has_service_args, name)
ask(rosservice.get_service_headers, "/flip", rosservice.get_service_uri("/flip"))
for word in ("type", "node", "uri", "args", "info"):
    ask(getattr(rosservice, "_rosservice_" + word), "/flip")
ask(rosservice._rosservice_type, "/not_there")
ask(rosservice._rosservice_list, "/talker", True)
ask(rosservice.rosservicemain, ["rosservice", "type", "/flip"])
for reply in ((1, "x", 2), (0, "x", 2), (-1, "x", 2)):
    ask(rosservice._succeed, reply)
for arguments in ([True], [{"data": False}], [], [1, 2], [{"other": 1}]):
    ask(rosservice.call_service, "/flip", arguments)
ask(rosservice.call_service, "/not_there", [])
ask(rosservice._rosservice_call, "/flip", [True], verbose=True)
ask(rosservice._rosservice_call, "/flip", [False])
"""

NODES = """
import rosnode
print(rosnode.ID, rosnode.NAME)
names = [name for name in rosnode.get_node_names() if name != "/rosout"]
print(names, rosnode.get_node_names("/talker"), rosnode.get_node_names("/not_there"))
for name in ("/talker", "/not_there"):
    ask(rosnode.get_api_uri, master, name)
    ask(rosnode.get_api_uri, master, name, True)
    ask(rosnode.rosnode_ping, name, 1)
    ask(rosnode.get_node_info_description, name)
print(len(rosnode.get_machines_by_nodes()) > 0, "/talker" in rosnode.get_nodes_by_machine("localhost"))
ask(rosnode.get_nodes_by_machine, "not-there.invalid")
ask(rosnode.rosnode_listnodes, "/talker")
ask(rosnode.rosnode_listnodes, "/talker", True)
ask(rosnode.rosnode_listnodes, "/talker", list_all=True)
uri = rosnode.get_api_uri(master, "/talker")
print(re.sub(r"[0-9]+", "N", rosnode.get_node_connection_info_description(uri, master)))
ask(rosnode.lookup_uri, master, master.getSystemState(), "/chatter", uri)
ask(rosnode.lookup_uri, master, master.getSystemState(), "/chatter", "http://localhost:1/")
ask(rosnode.kill_nodes, ["/not_there"])
rosgraph.Master("/ghost").registerPublisher("/seen", "std_msgs/String", "http://localhost:1/")
ask(rosnode.rosnode_ping, "/ghost", 1)
pinged, unpinged = rosnode.rosnode_ping_all()
print("/talker" in pinged, unpinged)
ask(rosnode.cleanup_master_blacklist, master, ["/ghost"])
print("/ghost" in rosnode.get_node_names())
rosgraph.Master("/ghost").registerSubscriber("/seen", "std_msgs/String", "http://localhost:1/")
ask(rosnode.cleanup_master_whitelist, master, names + ["/rosout"])
print("/ghost" in rosnode.get_node_names(), "/talker" in rosnode.get_node_names())
ask(rosnode.rosnodemain, ["rosnode", "list", "/talker"])
for reply in ((1, "x", 2), (0, "x", 2)):
    ask(rosnode._succeed, reply)
"""

PARAMETERS = """
import rosparam, yaml
from xmlrpc.client import Binary
def file(name, text):
    with open(os.path.join(sys.argv[1], name), "w") as out:
        out.write(text)
    return os.path.join(sys.argv[1], name)
def plain(value):
    if isinstance(value, Binary):
        return value.data
    return {key: plain(each) for key, each in value.items()} if isinstance(value, dict) else value
good = file("good.yaml", "a: 1\\nb: [1, 2.5, x]\\n"
    "c: {d: true, e: !degrees 90, f: rad(pi/2), g: deg(180), h: !radians pi/4}\\n"
    "i: !!binary aGVsbG8=\\nj: on\\nk: 0o17\\nl: 017\\nm: 2001-01-01\\nn: 1e3\\no: ~\\n")
for arguments in ((good,), (good, "/x"), (good, "rel")):
    print([(sorted((key, str(each)) for key, each in plain(document).items()), name)
        for document, name in rosparam.load_file(*arguments)])
ask(rosparam.load_file, file("ns.yaml", "_ns: inner\\na: 1\\n---\\nb: 2\\n---\\n_ns: /full\\nc: 3\\n"), "/outer")
ask(rosparam.load_file, os.path.join("not", "there.yaml"))
ask(rosparam.load_file, file("list.yaml", "- 1\\n"))
ask(rosparam.load_file, file("empty.yaml", ""))
try:
    rosparam.load_file(file("bad.yaml", "a: [1"))
except yaml.YAMLError as error:
    print(type(error).__name__)
ask(rosparam.load_str, "a: 1", "some name")
ask(rosparam.load_str, "{a: 1, _ns: q}", "some name", default_namespace="/y", verbose=True)
for name, value in (("/t/q", "1"), ("/t/s", "[1, a, 2.5]"), ("t/rel", "{a: 1, b: {c: 2}}"), ("/t/text", "abc def")):
    ask(rosparam.set_param, name, value)
    ask(rosparam.get_param, name)
ask(rosparam.set_param, "/t/v", "yes", verbose=True)
ask(rosparam.get_param, "/t/not_there")
ask(rosparam.get_param, "/t")
for name in ("/t", "t/rel", "/not_there", "/t/q"):
    ask(rosparam.list_params, name)
ask(rosparam.set_param_raw, "/t/r", [1, {"a": 2}])
ask(rosparam.set_param_raw, "/t/i", 2 ** 40)
ask(rosparam.set_param_raw, "/t/m", {"z": {"y": 5}}, True)
ask(rosparam.upload_params, "/t/up", {"a": 1, "b": {"c": "d"}}, verbose=True)
ask(rosparam.upload_params, "/t/one", 5)
ask(rosparam.upload_params, "/", 5)
ask(rosparam.upload_params, "/", {"t": {"only": {"x": 1}}, "t2": 2})
ask(rosparam.get_param, "/t")
out = os.path.join(sys.argv[1], "out.yaml")
ask(rosparam.dump_params, out, "/t", verbose=True)
print(open(out).read())
ask(rosparam.dump_params, out, "/not_there")
ask(rosparam.delete_param, "/t2", True)
ask(rosparam.delete_param, "/t")
ask(rosparam.get_param, "/t2")
ask(rosparam.print_params, {"a": {"b": 1}}, "/x")
ask(rosparam.print_params, 5, "/x")
for loader in (yaml.SafeLoader, yaml.Loader):
    print(yaml.load("[!degrees 90, deg(-90), rad(2*pi), !radians 1.5]", Loader=loader))
rosparam.set_param("/t3", "[1, 2]")
ask(rosparam.yamlmain, ["rosparam", "get", "/t3"])
ask(rosparam.yamlmain, ["rosparam", "delete", "/t3"])
rosparam.upload_params("/u/v", {"a": 1})
rosparam.upload_params("/u/v", {"b": {"c": 2}})
rosparam.upload_params("/", {"u": {"v": {"z": 1}}})  # stock drops empty dictionaries, ours does not
ask(rosparam.get_param, "/u")
rosparam.delete_param("/u")
print(issubclass(rosparam.RosParamIOException, rosparam.RosParamException))
print(rosparam.NS, rosparam.NAME, rosparam.GLOBALNS)
"""

DEFINITIONS = """
import rosmsg, rospkg
rospack = rospkg.RosPack()
print(rosmsg.MODE_MSG, rosmsg.MODE_SRV)
ask(rosmsg.list_types, "std_srvs", ".srv")
ask(rosmsg.list_types, "std_srvs", mode=".msg")
ask(rosmsg.list_types, "std_srvs", mode="x")
ask(rosmsg.list_types, "nav_msgs", rospack=rospack)
ask(rosmsg.list_msgs, "std_msgs")
ask(rosmsg.list_srvs, "nav_msgs")
for name in ("std_msgs/Header", "Header", "geometry_msgs/PoseStamped", "diagnostic_msgs/DiagnosticStatus"):
    ask(rosmsg.get_msg_text, name)
    ask(rosmsg.rosmsg_md5, ".msg", name if "/" in name else "std_msgs/String")
ask(rosmsg.get_msg_text, "std_msgs/String", True)
for name in ("std_srvs/SetBool", "std_srvs/Empty", "nav_msgs/GetPlan"):
    ask(rosmsg.get_srv_text, name)
    ask(rosmsg.rosmsg_md5, ".srv", name)
for function in (rosmsg.get_msg_text, rosmsg.get_srv_text):
    try:
        function("std_msgs/NotThere")
    except rosmsg.ROSMsgException as error:
        print(str(error).partition(":")[0])
ask(rosmsg.rosmsg_md5, ".msg", "std_msgs/NotThere")
try:
    rosmsg.list_types("not_there_at_all")
except rospkg.ResourceNotFound as error:
    print("not found", str(error).splitlines()[0])
print("std_msgs/Header" in rosmsg.rosmsg_search(rospack, ".msg", "Header"))
ask(rosmsg.rosmsg_debug, rospack, ".msg", "std_msgs/String")
folder = os.path.join(rospack.get_path("std_srvs"), "srv")
ask(rosmsg._list_types, folder, "srv", ".srv")
ask(rosmsg._list_types, "/not/there", "srv", ".srv")
print(("std_srvs", folder) in list(rosmsg.iterate_packages(rospack, ".srv")), rosmsg._msg_filter(".srv")(folder))
for argv, mode in ((["rosmsg", "md5", "std_msgs/String"], ".msg"), (["rossrv", "md5", "std_srvs/SetBool"], ".srv")):
    sys.argv = argv
    ask(rosmsg.rosmsgmain, mode)
sys.argv = ["rosmsg", "show", "std_msgs/ColorRGBA"]
ask(rosmsg.rosmsg_cmd_show, ".msg", "msg")
from geometry_msgs.msg import Point
print(rosmsg.get_yaml_for_msg(Point(1, 2, 3)))
ask(rosmsg.get_array_type_instance, "int32[3]")
ask(rosmsg.get_array_type_instance, "geometry_msgs/Point[]")
print(list(rosmsg.create_names_filter(["x"])(Point())))
"""


@pytest.fixture
def talker(launcher: Master) -> Iterator[Master]:
    """A node of stock's to ask about."""
    process = faces.start("stock", launcher, TALKER)
    faces.run("stock", launcher, "import rospy, rosservice\nrospy.wait_for_service('/talker/nothing', 20)\n"
              "while not rospy.has_param('/talker_runs'):\n    rospy.rostime.wallsleep(0.05)")  # fmt: skip
    until(
        lambda: any(each[4] == "/rosout" for each in launcher.node("/talker", "getBusInfo")[2]),
        "rosout hears the talker",
    )
    yield launcher
    process.close()


def test_signatures_are_stocks(master: Master) -> None:
    stock, ours = (json.loads(faces.run(face, master, SIGNATURES)) for face in faces.FACES)
    mains = {"rosservice.rosservicemain", "rosmsg.rosmsg_cmd_list", "rosmsg.rosmsg_cmd_packages"}  # sys.argv as default
    wanted = {
        name: form
        for name, form in stock.items()
        if (not name.partition(".")[2].startswith("_") or name in PRIVATE) and name not in mains | LEFT_OUT
    }
    assert {name: ours.get(name) for name in wanted} == wanted


@pytest.mark.parametrize("program", [TOPICS, SERVICES, NODES], ids=["topics", "services", "nodes"])
def test_questions_about_a_running_system(talker: Master, program: str, tmp_path: Path) -> None:
    faces.same(talker, HEAD + program, str(tmp_path))


PUBLISH = """
import rostopic
publisher, cls = rostopic.create_publisher("sent", "std_msgs/String", latch=True)
print(cls._type)
rostopic.wait_for_subscriber(publisher, 20)
rostopic.publish_message(publisher, cls, ["one"], once=True, verbose=True)
rostopic.publish_message(publisher, cls, [{"data": "two"}], None, True, False)
rostopic.publish_message(publisher, cls, ["three"], once=True)
for arguments in (["a", "b"], [{"other": 1}]):
    try:
        rostopic.publish_message(publisher, cls, arguments, once=True)
    except rostopic.ROSTopicException as error:
        print(str(error).splitlines()[-1])
try:
    rostopic.create_publisher("/x", "std_msgs/NotThere", latch=False)
except rostopic.ROSTopicException as error:
    print(str(error).splitlines()[0])
"""
HEAR = """
import rospy
from std_msgs.msg import String
heard = []
rospy.init_node("ear")
rospy.Subscriber("/sent", String, lambda message: heard.append(message.data))
deadline = rospy.get_time() + 30
while heard[-1:] != ["three"] and rospy.get_time() < deadline:
    rospy.sleep(0.02)
print(heard)
"""


def test_publishing(launcher: Master) -> None:
    said = []
    for face in faces.FACES:
        ear = faces.start("stock", launcher, HEAR)
        said.append(faces.run(face, launcher, HEAD + PUBLISH))
        ear.wait_line(r"^\['one', 'two', 'three'\]$")
        ear.wait(20)
    assert said[1] == said[0]


def test_rates(talker: Master) -> None:
    faces.same(talker, HEAD + RATES)


def test_parameters(launcher: Master, tmp_path: object) -> None:
    faces.same(launcher, HEAD + PARAMETERS, str(tmp_path))


def test_definitions(launcher: Master) -> None:
    faces.same(launcher, HEAD + DEFINITIONS)


def test_nodes_are_killed(launcher: Master) -> None:
    program = "import sys, rosnode\nprint(rosnode.kill_nodes(['/talker', '/not_there']))\n"
    for face in faces.FACES:
        process = faces.start("stock", launcher, TALKER)
        faces.run("stock", launcher, "import rospy\nrospy.wait_for_service('/talker/nothing', 20)")
        assert faces.run(face, launcher, program) == "(['/talker'], ['/not_there'])\n"
        assert process.wait(20) == 0


def test_without_a_master(master: Master) -> None:
    program = """
import rosnode, rosservice, rostopic
for module, function in ((rostopic, rostopic.get_topic_list), (rostopic, lambda: rostopic.get_topic_type("/x")),
        (rosservice, rosservice.get_service_list), (rosservice, lambda: rosservice.get_service_uri("/x")),
        (rosnode, rosnode.get_node_names), (rostopic, rostopic._check_master),
        (rostopic, lambda: rostopic.find_by_type("x"))):
    try:
        function()
    except Exception as error:
        print(type(error).__name__, error if not isinstance(error, OSError) else error.errno)
"""
    faces.same(master, program, ROS_MASTER_URI="http://localhost:1")
