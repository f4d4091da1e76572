"""interactive_marker_twist_server: drives a robot when its marker is dragged in rviz or on a web page.

See https://wiki.ros.org/interactive_marker_twist_server.
"""
