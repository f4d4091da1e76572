"""twist_mux: chooses between velocity commands by priority (https://wiki.ros.org/twist_mux)."""
