"""The modules of stock ROS 1 under their own names: rospy, genpy, std_msgs.msg and so on.

They are found by `finder.Finder`, which `start/sitecustomize.py` installs in programs that pyros1 starts, and
``pyros1 rospy enable`` in all programs of a virtual environment. Each module is a thin face on pyros1; their default node
(`process`) is the only state that belongs to the process.
"""
