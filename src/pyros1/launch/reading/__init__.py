"""Reads launch files into a plan. Only `system_resources` and `xacro_tool` access the system directly."""
