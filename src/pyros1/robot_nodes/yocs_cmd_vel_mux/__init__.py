"""yocs_cmd_vel_mux: chooses between velocity commands by priority (https://wiki.ros.org/yocs_cmd_vel_mux)."""
