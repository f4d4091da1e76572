"""Nodes that forward topics of any type without decoding: relay, drop, throttle, mux and demux.

See https://wiki.ros.org/topic_tools. The type of a topic is taken from its publishers' connection headers, so no
message packages are needed.
"""
