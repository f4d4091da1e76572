"""rosserial_python: boards with a microcontroller take part in ROS, over a serial line or TCP.

See https://wiki.ros.org/rosserial and https://wiki.ros.org/rosserial/Overview/Protocol.
"""
