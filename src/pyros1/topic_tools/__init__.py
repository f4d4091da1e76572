"""Nodes that forward topics of any type, still encoded: relay, drop, throttle, mux and demux.

See https://wiki.ros.org/topic_tools. The type of a topic comes from its publishers' connection headers, so no message
packages are needed and nothing is decoded.
"""
