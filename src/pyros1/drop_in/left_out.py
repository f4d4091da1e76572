"""Packages and modules of stock that pyros1 lacks, each with a text for the error of its import."""

from __future__ import annotations

_CORE = "`pyros1 core` and `pyros1 master` are the master"
_NODE = "pyros1's nodes do this themselves"
_LAUNCH = "`pyros1 launch` does this itself"
_COMPILED = "it is compiled code"
_STACKS = "stacks were rosbuild's; see rospkg.RosPack"
_ROSPKG = "`pip install rospkg` has it"

REASONS = {
    "rosmaster": _CORE,
    "rosclean": "see the command `pyros1 clean`",
    "roslz4": "pyros1.bag reads and writes chunks with LZ4; see the module lz4 of PyPI",
    "roswtf": "see the command `pyros1 wtf`",
    "rosconsole": "see the command `pyros1 console`",
    "PyKDL": f"{_COMPILED}; tf2_kdl, tf_conversions.posemath and pyros1.tf.transformations do without it",
    "kdl_parser_py": "it needs PyKDL; see pyros1.urdf",
    "rviz": "see the command `pyros1 web scene`",
    "rqt_gui": "see the command `pyros1 web`",
    "rqt_gui_py": "see the command `pyros1 web`",
    "qt_gui": "see the command `pyros1 web`",
    "python_qt_binding": "see the command `pyros1 web`",
    "pluginlib": "plugins are compiled code",
    "resource_retriever": "see pyros1.urdf and roslib.packages for package:// addresses",
    "moveit_commander": f"{_COMPILED} for the most part",
    "rospy.impl.masterslave": _NODE,
    "rospy.impl.tcpros_pubsub": _NODE,
    "rospy.impl.udpros": _NODE,
    "roslaunch.child": _LAUNCH,
    "roslaunch.remote": _LAUNCH,
    "roslaunch.remoteprocess": _LAUNCH,
    "genmsg.deps": "see genmsg.load_depends, and MsgContext.get_all_depends and get_file",
    "genmsg.template_tools": "classes are made when they are imported; nothing is generated",
    "roslib.gentools": "see genmsg.gentools, or a message class's _md5sum and _full_text",
    "roslib.manifestlib": "see rospkg.Manifest",
    "roslib.resources": "list the folder that roslib.packages.get_pkg_dir returns",
    "roslib.stack_manifest": _STACKS,
    "roslib.stacks": _STACKS,
    "rospkg.rosversion": "see the command `pyros1 version`",
    "rospkg.stack": _ROSPKG,
    "rosunit.pmon": "see roslaunch.pmon",
    "dynamic_reconfigure.cfg": "Debian's TestConfig is made by a build; .cfg files are read where they lie",
}


def reason_for(module: str) -> str:
    """Return why a module is missing, after a colon; an empty text for unknown modules."""
    reason = REASONS.get(module)
    return f": {reason}" if reason else ""
