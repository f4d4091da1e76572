"""Which tests can run here."""

import os

collect_ignore = [] if os.environ.get("PYROS1_ROS2_PYTHON") else ["test_rclpy.py"]
"""It needs ROS 2, which `interop/setup` does not install: 280 MB of unofficial wheels."""
