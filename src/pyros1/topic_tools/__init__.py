"""Nodes that forward topics of any type, still encoded: relay, drop, throttle, mux and demux.

https://wiki.ros.org/topic_tools. What a topic carries they learn from its publishers' connection headers, so no message
package is needed and nothing is decoded.
"""
