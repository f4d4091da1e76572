"""The program flat_world of the package two_wheeler: simulates robots with two wheels in a flat world, made from a map.

It is in the spirit of stage (https://wiki.ros.org/stage_ros).
"""
