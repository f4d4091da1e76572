"""Reads launch files into a plan. Only `world` and `xacro_tool` access the system directly."""
