"""yocs_velocity_smoother: limits speeds and accelerations (https://wiki.ros.org/yocs_velocity_smoother)."""
