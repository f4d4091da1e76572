"""rosserial_python: connects microcontroller boards to ROS, over a serial port or TCP.

See https://wiki.ros.org/rosserial and https://wiki.ros.org/rosserial/Overview/Protocol.
"""
