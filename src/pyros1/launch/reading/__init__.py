"""From launch files to a plan. Pure, except `world` and `xacro_tool`."""
