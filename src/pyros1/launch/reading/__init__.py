"""Reads launch files into a plan. Pure, except `world` and `xacro_tool`."""
