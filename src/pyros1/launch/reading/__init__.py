"""Launch files to a plan. Pure, but for `world` and `xacro_tool`."""
