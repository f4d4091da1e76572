"""genpy, genmsg, rosgraph, roslib, rospkg, and the libraries of images and clouds, as programs use them."""

from __future__ import annotations

from pathlib import Path

import pytest
from programs import START, run
from smach_modules import imported

GENPY = """
import io, genmsg, genpy, genpy.message as gm, genpy.dynamic, roslib.message
from genpy.rostime import Time, Duration, TVal
from geometry_msgs.msg import TwistStamped
from std_msgs.msg import Header, String
message = TwistStamped()
gm.fill_message_args(message, ["auto", {"linear": {"x": 1.5}}], {"auto": Header(frame_id="map")})
assert message.header.frame_id == "map" and message.twist.linear.x == 1.5
assert gm.get_printable_message_args(Header()) == "seq stamp frame_id"
assert gm.strify_message(String("a")) == 'data: "a"' == str(String("a"))
assert roslib.message.get_message_class("std_msgs/Header") is Header and gm.isstring("x")
assert roslib.message.get_service_class("std_srvs/Nothing") is None
classes = genpy.dynamic.generate_dynamic(TwistStamped._type, TwistStamped._full_text)
assert {"geometry_msgs/Twist", "geometry_msgs/TwistStamped", "geometry_msgs/Vector3", "std_msgs/Header"} == set(classes)
buffer = io.BytesIO()
classes["geometry_msgs/TwistStamped"]().serialize(buffer)
assert TwistStamped().deserialize(buffer.getvalue()) == TwistStamped() and isinstance(message, genpy.Message)
for wrong, kind in (("int8", 200), ("uint8", -1), ("string", 3), ("std_msgs/String", 1), ("no/No", 1), ("bool", 2)):
    try:
        gm.check_type("field", wrong, kind)
    except genpy.SerializationError as error:
        assert "field" in str(error)
    else:
        raise AssertionError(wrong)
gm.check_type("field", "std_msgs/Header[]", [Header()])
assert genpy.struct_I.size == 4 and issubclass(genpy.DeserializationError, genpy.MessageException)
assert str(genpy.DeserializationError("text")) == "text"
try:
    genpy.dynamic.generate_dynamic("a/B", "int8")
except genmsg.InvalidMsgSpec:
    print("done")
"""

GENMSG = """
import sys, genmsg
from genmsg import msg_loader
context = genmsg.MsgContext.create_default()
spec = msg_loader.load_msg_from_string(context, "int32 X=3\\nOther[2] o\\ntime t", "a/B")
msg_loader.load_msg_from_string(context, "string s", "a/Other")
assert genmsg.load_depends(context, spec, {}) == ["a/Other"] and context.get_all_depends("a/B") == ["a/Other"]
assert genmsg.compute_md5_text(context, spec).startswith("int32 X=3") and len(genmsg.compute_md5(context, spec)) == 32
assert "MSG: a/Other" in genmsg.compute_full_text(context, spec)
assert [(f.name, f.base_type, f.array_len) for f in spec.parsed_fields()] == [("o", "a/Other", 2), ("t", "time", None)]
for text in ("int8", "int8 X=300", "a-b c"):
    try:
        msg_loader.load_msg_from_string(context, text, "a/C")
    except genmsg.InvalidMsgSpec:
        continue
    raise AssertionError(text)
try:
    genmsg.load_msg_by_type(context, "b/B", {})
except genmsg.MsgNotFound:
    print("done")
"""

CLOUDS = """
import numpy, ros_numpy, struct
import sensor_msgs.point_cloud2 as pc2
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header
nan = float("nan")
cloud = pc2.create_cloud_xyz32(Header(), [(1, 2, 3), (4, nan, 6)])
assert list(pc2.read_points(cloud, skip_nans=True)) == [(1, 2, 3)]
assert list(pc2.read_points(cloud, ("z", "x"), uvs=[(1, 0)])) == [(4, 6)]
assert pc2.read_points_list(cloud)[0].y == 2
same = pc2.create_cloud_xyz32(Header(), numpy.array([[1, 2, 3], [4, nan, 6]]))
assert same.data == cloud.data
fields = [PointField("x", 0, PointField.FLOAT32, 1), PointField("n", 6, PointField.UINT16, 2)]
odd = pc2.create_cloud(Header(), fields, [(1.5, 7, 8), (2.5, 9, 10)])
assert list(pc2.read_points(odd)) == [(1.5, 7, 8), (2.5, 9, 10)] and odd.point_step == 10
data = struct.pack(">fxxHH", 1.5, 7, 8)
big = PointCloud2(height=1, width=1, fields=fields, is_bigendian=True, point_step=10, row_step=10, data=data)
assert list(pc2.read_points(big)) == [(1.5, 7, 8)] and list(pc2.read_points(big, skip_nans=True)) == [(1.5, 7, 8)]
short = PointCloud2(height=1, width=2, fields=fields, point_step=10, row_step=20, data=b"123")
try:
    list(pc2.read_points(short))
except struct.error:
    pass
array = ros_numpy.numpify(cloud)
assert array.dtype.names == ("x", "y", "z") and ros_numpy.msgify(PointCloud2, array).data == cloud.data
assert ros_numpy.point_cloud2.pointcloud2_to_xyz_array(cloud).tolist() == [[1, 2, 3]]
empty = PointCloud2(height=1, width=9, fields=fields, point_step=10, row_step=90)
for read in (lambda: list(pc2.read_points(empty, skip_nans=True)), lambda: ros_numpy.numpify(empty)):
    try:
        read()
    except (struct.error, ValueError):
        continue
    raise AssertionError(read)

# Clouds that claim more than any memory holds.
import resource
resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))
most = 2**32 - 1
lying = (
    (PointField("x", 0, PointField.FLOAT32, 1), most),
    (PointField("x", 0, PointField.FLOAT32, most), 1),
    (PointField("x", most, PointField.FLOAT32, 1), 1),
)
for field, size in lying:
    short = PointCloud2(fields=[field], height=size, width=size, point_step=4, row_step=4, data=bytes(8))
    try:
        list(pc2.read_points(short))
    except struct.error:
        continue
    raise AssertionError(field)
fields = [PointField("x", 0, PointField.FLOAT32, 1)]
assert not list(pc2.read_points(PointCloud2(fields=fields, height=most, width=0, point_step=1)))
wrong = (
    PointCloud2(fields=[PointField("x", most, PointField.FLOAT32, 1)], height=1, width=1, point_step=4, data=bytes(8)),
    PointCloud2(fields=[PointField("x", 0, PointField.FLOAT32, most)], height=1, width=1, point_step=4, data=bytes(8)),
    PointCloud2(fields=fields, height=1, width=0, point_step=most),
    PointCloud2(fields=fields, height=most, width=1, point_step=0, data=bytes(8)),
    PointCloud2(fields=fields, height=5, width=2, point_step=4, row_step=1, data=bytes(12)),
)
for cloud in wrong:
    try:
        ros_numpy.numpify(cloud)
    except ValueError:
        continue
    raise AssertionError(cloud)
print("done")
"""

IMAGES = """
import numpy as np, ros_numpy, cv_bridge
from sensor_msgs.msg import Image
bridge = cv_bridge.CvBridge()
picture = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
message = bridge.cv2_to_imgmsg(picture, "bgr8")
assert (message.width, message.height, message.step) == (4, 2, 12)
assert (bridge.imgmsg_to_cv2(message) == picture).all()
assert (bridge.imgmsg_to_cv2(message, "rgb8") == picture[..., ::-1]).all()
assert bridge.imgmsg_to_cv2(message, "mono8").tolist()[0][0] == 1
assert bridge.imgmsg_to_cv2(message, "rgb16")[0, 0, 0] == 2 * 257
padded = Image(height=2, width=1, encoding="mono8", step=3, data=b"\\1xx\\2xx")
assert bridge.imgmsg_to_cv2(padded).tolist() == [[1], [2]]
wide = Image(height=1, width=2, encoding="16UC1", is_bigendian=1, step=4, data=b"\\0\\1\\1\\0")
assert bridge.imgmsg_to_cv2(wide).tolist() == [[1, 256]]
assert bridge.imgmsg_to_cv2(wide, "32FC1").dtype == np.float32
import io
from PIL import Image as Picture
from sensor_msgs.msg import CompressedImage
file = io.BytesIO()
Picture.fromarray(np.array([[0.25, 7.5]], np.float32)).save(file, "TIFF")
floats = CompressedImage(format="tiff", data=file.getvalue())
colours = bridge.compressed_imgmsg_to_cv2(floats, "bgra8")
assert (colours.dtype, colours.tolist()) == (np.float32, [[[0.25, 0.25, 0.25, 1.0], [7.5, 7.5, 7.5, 1.0]]])
grey = cv_bridge.encodings.convert_color_order(np.array([[[0.5, 0.25, 1.0]]], np.float32), "bgr", "m")
assert grey.dtype == np.float32 and abs(grey[0, 0] - 0.50275) < 1e-3  # as OpenCV, which alone reads such files
for make in (
    lambda: bridge.cv2_to_imgmsg(picture, "mono8"), lambda: bridge.imgmsg_to_cv2(Image(encoding="no")),
    lambda: bridge.imgmsg_to_cv2(Image(encoding="8UC0", height=2**32 - 1, width=2**32 - 1)),
    lambda: bridge.imgmsg_to_cv2(wide, "bgr8"),
    lambda: bridge.imgmsg_to_cv2(Image(encoding="mono8", width=9, height=9)),
):
    try:
        make()
    except cv_bridge.CvBridgeError as error:
        assert str(error)
    else:
        raise AssertionError(make)
assert (ros_numpy.numpify(ros_numpy.msgify(Image, picture, encoding="rgb8")) == picture).all()
print("done")
"""

GEOMETRY = """
import numpy as np, ros_numpy, image_geometry
from geometry_msgs.msg import Point, Pose, Quaternion, Transform, Vector3
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import CameraInfo
pose = Pose(Point(1, 2, 3), Quaternion(0, 0, 0.6, 0.8))
matrix = ros_numpy.numpify(pose)
again = ros_numpy.msgify(Pose, matrix)
assert abs(again.orientation.z - 0.6) < 1e-9 and again.position.z == 3
assert ros_numpy.numpify(Vector3(1, 2, 3), hom=True).tolist() == [1, 2, 3, 0]
assert ros_numpy.msgify(Transform, np.stack([matrix, matrix])).shape == (2,)
grid = ros_numpy.msgify(OccupancyGrid, np.array([[0, -1]], np.int8))
assert ros_numpy.numpify(grid).tolist() == [[0, None]] and grid.info.width == 2
model = image_geometry.PinholeCameraModel()
K, R, P = [2, 0, 2, 0, 2, 2, 0, 0, 1], [1, 0, 0, 0, 1, 0, 0, 0, 1], [2, 0, 2, 0, 0, 2, 2, 0, 0, 0, 1, 0]
model.fromCameraInfo(CameraInfo(width=4, height=4, K=K, R=R, P=P))
assert model.project3dToPixel((0, 0, 1)) == (2, 2) and model.projectPixelTo3dRay((2, 2)) == (0, 0, 1)
print("done")
"""

CAMERA = """
import os, sys
from camera_info_manager import CameraInfoManager, CameraInfoMissingError, saveCalibrationFile
from sensor_msgs.msg import CameraInfo
info = CameraInfo(width=6, height=4, distortion_model="plumb_bob", D=[0.1], K=[1] * 9, R=[1] * 9, P=[1] * 12)
place = os.path.join(sys.argv[1], "new", "cam.yaml")
manager = CameraInfoManager("cam", "file://" + place)
try:
    manager.isCalibrated()
except CameraInfoMissingError:
    pass
manager.loadCameraInfo()
assert not manager.isCalibrated() and saveCalibrationFile(info, place, "cam")
manager.loadCameraInfo()
assert manager.isCalibrated() and manager.getCameraInfo() == info and not manager.setURL("nowhere")
print("done")
"""

ROSGRAPH = """
import io, socket, xmlrpc.client, threading, rosgraph
from rosgraph import names, network, xmlrpc as node_xmlrpc
from rosgraph.impl import graph
assert names.resolve_name("~a", "/ns/node") == "/ns/node/a" and names.ns_join("/a", "b") == "/a/b"
words = ["a:=b", "_p:=1", "__name:=n", "-o:=f", "a b:=c", "1:=d", "e:= "]
assert names.load_mappings(words) == {"a": "b", "__name": "n"}
assert rosgraph.myargv(["p", "a:=b", "c"]) == ["p", "c"]
data = network.encode_ros_handshake_header({"a": "b"})
assert network.decode_ros_handshake_header(data) == {"a": "b"}
one, other = socket.socketpair()
with one, other:
    network.write_ros_handshake_header(one, {"x": "y"})
    assert network.read_ros_handshake_header(other, io.BytesIO(), 8) == {"x": "y"}
ready = threading.Event()
class Handler(node_xmlrpc.XmlRpcHandler):
    def _ready(self, uri):
        ready.set()
    def double(self, number):
        return 2 * number
node = node_xmlrpc.XmlRpcNode(0, Handler())
node.start()
assert ready.wait(20) and xmlrpc.client.ServerProxy(node.uri).double(4) == 8
node.shutdown("done")
master = rosgraph.Master("/me", "http://127.0.0.1:1/")
assert master.caller_id == "/me" and not master.is_online()
try:
    master.getPid()
except OSError as error:
    assert "127.0.0.1:1" in str(error)
assert not graph.Graph().update() and graph.topic_node("/a") == " /a"
print("done")
"""

ROSLIB = """
import logging, os, roslib.manifest, roslib.names, roslib.msgs, roslib.srvs, roslib.rosenv, roslib.scriptutil
import roslib.network, roslib.msg
import roslib.rospack, roslib.rostime, roslib.genpy, rosgraph.roslogging
assert roslib.names.resource_name("std_msgs", "String") == "std_msgs/String" and roslib.names.TYPE_SEPARATOR == "/"
assert roslib.names.resource_name_package("a/B") == "a" and roslib.names.is_legal_resource_name("a/B")
assert roslib.msgs.parse_type("int8[3]") == ("int8", True, 3) and roslib.msgs.is_valid_constant_type("int8")
name, spec = roslib.msgs.load_by_type("std_msgs/String")
assert spec.fields() == [("string", "data")] and "String" in roslib.msgs.list_msg_types("std_msgs", False)
assert roslib.msgs.resolve_type("String", "std_msgs") == "std_msgs/String"
assert roslib.msgs.base_msg_type("a/B[]") == "a/B"
assert roslib.manifest.manifest_file("std_msgs", required=False).endswith("manifest.xml")
assert roslib.srvs.load_from_string("int8 a\\n---\\n", "p").request.names == ["a"]
assert "SetBool" in roslib.srvs.list_srv_types("std_srvs", False)
for wrong in ("int8", "int8["):
    try:
        roslib.msgs.parse_type(wrong + "[")
    except roslib.msgs.MsgSpecException:
        continue
    raise AssertionError(wrong)
assert roslib.rosenv.get_master_uri() == os.environ["ROS_MASTER_URI"]
assert roslib.rosenv.get_ros_root(required=False) is None
assert roslib.scriptutil.script_resolve_name("/s", "~a") == "/s/a" and roslib.scriptutil.get_master() is not None
assert roslib.network.parse_http_host_and_port("http://a:5/") == ("a", 5) and roslib.msg.Header().seq == 0
assert roslib.rospack.rospackexec(["find", "nothing"]) == "" and roslib.rostime.Time(1) > roslib.rostime.Time()
path = rosgraph.roslogging.configure_logging("tool", logging.INFO)
logging.getLogger("x").info("written")
assert "written" in open(path).read()
print("done")
"""


@pytest.mark.slow
@pytest.mark.parametrize("program", [ROSLIB, GENPY, GENMSG, CLOUDS, IMAGES, GEOMETRY, CAMERA, ROSGRAPH])
def test_a_program(program: str, tmp_path: Path) -> None:
    environ = {"ROS_MASTER_URI": "http://127.0.0.1:1/", "ROS_HOSTNAME": "127.0.0.1", "ROS_HOME": str(tmp_path)}
    assert run(program, environ, str(tmp_path)).splitlines()[-1] == "done"


PACKAGES = """
import os, sys, rospkg, roslib, roslib.packages
workspace = sys.argv[1]
pack = rospkg.RosPack()
assert pack.get_path("a") == workspace + "/a" and "std_msgs" in pack.list()
assert pack.get_depends("a") == ["b", "c"] and pack.get_depends("a", implicit=False) == ["b"]
assert set(rospkg.RosPack([workspace]).list()) == {"a", "b", "c"}
assert pack.get_depends_on("c", implicit=False) == ["b"]
assert pack.get_rosdeps("a", implicit=False) == ["python3-yaml"]
assert pack.get_manifest("a").get_export("cpp", "cflags") == ["-I" + workspace + "/a/include"]
try:
    pack.get_path("nothing")
except rospkg.ResourceNotFound as error:
    assert str(error).startswith("nothing")
assert rospkg.get_package_name(workspace + "/a/src") == "a" and rospkg.on_ros_path(workspace + "/a")
assert rospkg.get_log_dir({"ROS_HOME": "/x"}) == "/x/log"
assert roslib.packages.get_pkg_dir("b") == workspace + "/b"
assert roslib.packages.get_pkg_dir("no", required=False) is None
assert roslib.packages.find_node("a", "run") == [workspace + "/a/scripts/run"]
assert roslib.packages.find_resource("a", "run") == [workspace + "/a/scripts/run"]
roslib.load_manifest("a")
roslib.load_manifest("not_there")
assert workspace + "/a/src" in sys.path
print("done")
"""


def test_packages(tmp_path: Path) -> None:
    head = "<package format='2'><name>{}</name><version>0.1.0</version>"
    export = "<export><cpp cflags='-I${prefix}/include'/></export>"
    for name, rest in (
        ("a", f"<exec_depend>b</exec_depend><exec_depend>python3-yaml</exec_depend>{export}"),
        ("b", "<depend>c</depend>"),
        ("c", ""),
    ):
        (tmp_path / name).mkdir()
        (tmp_path / name / "package.xml").write_text(head.format(name) + rest + "</package>")
    (tmp_path / "a" / "src").mkdir()
    (tmp_path / "a" / "scripts").mkdir()
    script = tmp_path / "a" / "scripts" / "run"
    script.write_text("#!/bin/sh\n")
    script.chmod(0o755)
    assert run(PACKAGES, {"ROS_PACKAGE_PATH": str(tmp_path)}, str(tmp_path)) == "done\n"


@pytest.mark.slow
def test_manifests_that_are_not_xml(tmp_path: Path) -> None:
    package, manifest = tmp_path / "package.xml", tmp_path / "manifest.xml"
    texts = (
        b"<?xml version='1.0' encoding='klingon'?><package><name>p</name></package>",
        b"<package><license>",
        b"<!DOCTYPE a [<!ENTITY b 'c'>]><package>&b;</package>",
        b"<package><description>" + b"<b>" * 100_000 + b"</b>" * 100_000 + b"</description></package>",
        b"<package><depend/></package>",
    )
    with imported("rospkg.manifest") as module:
        for file in (package, manifest):
            for text in texts:
                file.write_bytes(text)
                with pytest.raises(module.InvalidManifest, match="invalid XML"):
                    module.parse_manifest_file(str(tmp_path), file.name)
        manifest.write_text("<stack/>")
        with pytest.raises(module.InvalidManifest, match="single 'package' element"):
            module.parse_manifest_file(str(tmp_path), "manifest.xml")


@pytest.mark.slow
def test_what_rospkg_lacks_says_what_has_it() -> None:
    for module, name in (
        ("rospkg", "expand_to_packages"),
        ("rospkg.distro", "load_distro"),
        ("rospkg.rospack", "RosStack().get_stack_version"),
    ):
        out = run(f"import {module}; {module}.{name}", {}, code=1)
        assert "AttributeError: pyros1 has no" in out and "`pip install rospkg` provides" in out, out
    assert (
        run("import rospkg.os_detect as o; print(o.OsDetect().detect_os()[0])", {"ROS_OS_OVERRIDE": "a:1:b"}) == "a\n"
    )
    assert "`pip install rospkg` provides it" in run("import rospkg.stack", {}, code=1)


def test_an_installed_rospkg_wins(tmp_path: Path) -> None:
    (tmp_path / "rospkg").mkdir()
    (tmp_path / "rospkg" / "__init__.py").touch()
    environ = {"PYTHONPATH": f"{START}:{tmp_path}"}
    assert run("import rospy, rospkg; print(rospkg.__file__)", environ) == f"{tmp_path}/rospkg/__init__.py\n"
