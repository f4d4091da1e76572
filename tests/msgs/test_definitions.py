"""The definitions that come with pyros1: complete, comment-free, md5 sums as everybody knows them (G13, G30)."""

from __future__ import annotations

from pathlib import Path

import codec
import pytest

from pyros1.finding.library import SHIPPED_DEFINITIONS, Library
from pyros1.msgs.factory import make_message_class

LIBRARY = Library({}, installs=[])
FILES = sorted(path for path in Path(SHIPPED_DEFINITIONS).rglob("*") if path.is_file())

# Sums that the generated classes of ROS distributions carry.
KNOWN = """
std_msgs/String 992ce8a1687cec8c8bd883ec73ca41d1
std_msgs/Header 2176decaecbce78abc3b96ef049fabed
std_msgs/Empty d41d8cd98f00b204e9800998ecf8427e
std_msgs/Float64 fdb28210bfa9d7c91146260178d9a584
rosgraph_msgs/Log acffd30cd6b6de30f120938c17c593fb
geometry_msgs/PoseStamped d3812c3cbc69362b77dc0b19b345f8f5
geometry_msgs/Twist 9f195f881246fdfa2798d1d3eebca84a
std_srvs/SetBool 09fb03525b03e7ea1fd3992bafd87e16
sensor_msgs/Image 060021388200f6f0f447d0fcd9c64743
tf/tfMessage 94810edda583a504dfda3829e70d7eec
tf2_msgs/TFMessage 94810edda583a504dfda3829e70d7eec
tf/FrameGraph c4af9ac907e58e906eb0b6e3c58478c0
turtlesim/Pose 863b248d5016ca62ea2e895ae5265cf9
turtlesim/Color 353891e354491c51aabe32df673fb446
turtlesim/Spawn 0b2d2e872a8e2887d5ed626f2bf2c561
turtlesim/Kill c1f3d28f1b044c871e6eff2e9fc3c667
turtlesim/SetPen 9f452acce566bf0c0954594f69a8e41b
turtlesim/TeleportAbsolute a130bc60ee6513855dc62ea83fcc5b20
turtlesim/TeleportRelative 9d5c2dcd348ac8f76ce2a4307bd63a13
rospy_tutorials/Floats 420cd38b6b071cd49f2970c3e2cee511
rospy_tutorials/HeaderString c99a9440709e4d4a9716d55b8270d5e7
rospy_tutorials/AddTwoInts 6a2e34150c00229791cc89ff309fff21
rospy_tutorials/BadTwoIntsRequest 29bb5c7dea8bf822f53e94b0ee5a3a56
roscpp_tutorials/TwoInts 6a2e34150c00229791cc89ff309fff21
turtle_actionlib/ShapeAction d73b17d6237a925511f5d7727a1dc903
turtle_actionlib/Velocity 9d5c2dcd348ac8f76ce2a4307bd63a13
actionlib_tutorials/FibonacciAction f59df5767bf7634684781c92598b2406
actionlib_tutorials/AveragingAction 628678f2b4fa6a5951746a4a2d39e716
smach_msgs/SmachContainerInitialStatusCmd 45f8cf31fc29b829db77f23001f788d6
smach_msgs/SmachContainerStatus 5ba2bb79ac19e3842d562a191f2a675b
smach_msgs/SmachContainerStructure 3d3d1e0d0f99779ee9e58101a5dcf7ea
control_msgs/FollowJointTrajectoryAction bc4f9b743838566551c0390c65f1a248
control_msgs/JointTrajectoryAction a04ba3ee8f6a2d0985a6aeaf23d9d7ad
control_msgs/GripperCommandAction 950b2a6ebe831f5d4f4ceaba3d8be01e
control_msgs/PointHeadAction 7252920f1243de1b741f14f214125371
control_msgs/SingleJointPositionAction c4a786b7d53e5d0983decf967a5a779e
control_msgs/GripperCommand 680acaff79486f017132a7f198d40f08
control_msgs/JointControllerState 987ad85e4756f3aef7f1e5e7fe0595d1
control_msgs/JointTolerance f544fe9c16cf04547e135dd6063ff5be
control_msgs/JointTrajectoryControllerState 10817c60c2486ef6b33e97dcd87f4474
control_msgs/PidState b138ec00e886c10e73f27e8712252ea6
control_msgs/JointJog 1685da700c8c2e1254afc92a5fb89c96
control_msgs/QueryCalibrationState 28af3beedcb84986b8e470dc5470507d
control_msgs/QueryTrajectoryState ec93cdecbd8062d761aa52b7c90cd44b
controller_manager_msgs/HardwareInterfaceResources f25b55cbf1d1f76e82e5ec9e83f76258
controller_manager_msgs/ControllerState aeb6b261d97793ab74099a3740245272
controller_manager_msgs/ListControllers 1341feb2e63fa791f855565d0da950d8
controller_manager_msgs/LoadController 647e5c54b8d6468952d8d31f1efe96c0
controller_manager_msgs/SwitchController b29a7abc673b2c54c14b54e50f8d06a5
tf2_web_republisher/TFSubscriptionActionGoal ef8da891ba3ba9b13d97bca8154eaeb5
rosapi/TypeDef 80597571d79bbeef6c9c4d98f30116a0
rosapi/Topics d966d98fc333fa1f3135af765eac1ba8
rosapi/MessageDetails f9c88144f6f6bd888dd99d4e0411905d
geographic_msgs/GeoPoint c48027a852aeff972be80478ff38e81a
robot_localization/SetDatum fe903ca95d0210defda73a1629604439
robot_localization/SetPose 4f3e0bbe7a24e1f929488cd1970222d3
"""

PACKAGES = """actionlib actionlib_msgs actionlib_tutorials bond control_msgs controller_manager_msgs diagnostic_msgs
dynamic_reconfigure geometry_msgs map_msgs move_base_msgs nav_msgs nodelet pcl_msgs rosgraph_msgs roscpp
roscpp_tutorials rospy_tutorials sensor_msgs shape_msgs smach_msgs std_msgs std_srvs stereo_msgs tf tf2_msgs topic_tools
trajectory_msgs turtle_actionlib turtlesim visualization_msgs tf2_web_republisher
rosapi rosbridge_msgs twist_mux_msgs rosserial_msgs robot_localization geographic_msgs"""


@pytest.mark.parametrize("line", KNOWN.split("\n")[1:-1])
def test_g13_known_sums(line: str) -> None:
    name, md5 = line.split()
    package, short = name.split("/")
    if short in LIBRARY.services(package):
        assert LIBRARY.digests.md5(LIBRARY.service(name)) == md5
    elif short.endswith("Request"):
        assert LIBRARY.digests.md5(LIBRARY.service(name.removesuffix("Request")).request) == md5
    else:
        assert LIBRARY.digests.md5(LIBRARY.message(name)) == md5


def test_g30_packages() -> None:
    assert set(PACKAGES.split()) <= set(LIBRARY.packages())


@pytest.mark.parametrize("path", FILES, ids=lambda path: "/".join(path.parts[-3:]))
def test_files_hold_fields_and_constants_only_and_all_they_use_is_there(path: Path) -> None:
    package, kind, file = path.parts[-3:]
    assert kind in ("msg", "srv", "action") and file.endswith(f".{kind}")
    text = path.read_text()
    for line in text.splitlines():
        assert line == line.strip() and line
        assert "#" not in line
    name = f"{package}/{path.stem}"
    if kind == "srv":
        service = LIBRARY.service(name)
        parts = [service.request, service.response]
    elif kind == "msg":
        parts = [LIBRARY.message(name)]
    else:
        parts = [LIBRARY.message(name + part) for part in ("Goal", "Result", "Feedback")]
    for part in parts:
        assert len(LIBRARY.digests.md5(part)) == 32
        LIBRARY.digests.dependencies(part)


@pytest.mark.slow
def test_all_messages_encode_and_decode_their_defaults() -> None:
    classes: dict[str, type] = {}

    def lookup(name: str) -> type:
        if name not in classes:
            classes[name] = make_message_class(LIBRARY.message(name), LIBRARY.digests, lookup, "test")
        return classes[name]

    for package in PACKAGES.split():
        for short in LIBRARY.messages(package):
            cls = lookup(f"{package}/{short}")
            data = codec.encode(cls())
            assert codec.decode(cls, data, 0, len(data)) == cls()
