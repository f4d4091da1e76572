"""rospkg, by pyros1: finds ROS packages (https://wiki.ros.org/rospkg); only has the parts that programs use.

If rospkg is installed, from PyPI or Debian, programs import that package instead.
"""

from pyros1.drop_in.module_attributes import module_getattr
from rospkg.common import MANIFEST_FILE, STACK_FILE, ResourceNotFound
from rospkg.environment import (
    get_etc_ros_dir,
    get_log_dir,
    get_ros_home,
    get_ros_package_path,
    get_ros_paths,
    get_ros_root,
    get_test_results_dir,
    on_ros_path,
)
from rospkg.manifest import InvalidManifest, Manifest, parse_manifest_file
from rospkg.rospack import RosPack, RosStack, get_package_name, list_by_path

__all__ = [
    "MANIFEST_FILE",
    "STACK_FILE",
    "InvalidManifest",
    "Manifest",
    "ResourceNotFound",
    "RosPack",
    "RosStack",
    "get_etc_ros_dir",
    "get_log_dir",
    "get_package_name",
    "get_ros_home",
    "get_ros_package_path",
    "get_ros_paths",
    "get_ros_root",
    "get_test_results_dir",
    "list_by_path",
    "on_ros_path",
    "parse_manifest_file",
]

__version__ = "1.4.0"  # the version of PyPI's rospkg whose API this is

_REASON = "`pip install rospkg` provides it"
__getattr__ = module_getattr(__name__, expand_to_packages=_REASON, get_stack_version_by_dir=_REASON)
