"""The Python modules of sensor_msgs; its messages are in sensor_msgs.msg, as those of all packages."""
