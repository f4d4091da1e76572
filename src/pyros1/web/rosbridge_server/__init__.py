"""The package rosbridge_server: a server for rosbridge clients only, with the parameters of the original.

See https://wiki.ros.org/rosbridge_server.
"""
