"""interactive_marker_twist_server: drives a robot by dragging a marker in rviz or on a page.

See https://wiki.ros.org/interactive_marker_twist_server.
"""
