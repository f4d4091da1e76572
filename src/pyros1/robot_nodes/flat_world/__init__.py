"""The program flat_world of the package two_wheeler: simulates two-wheeled robots in a 2D world made from a map.

It is similar to stage (https://wiki.ros.org/stage_ros).
"""
