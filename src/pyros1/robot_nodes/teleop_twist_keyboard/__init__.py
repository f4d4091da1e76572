"""The package teleop_twist_keyboard: drives a robot with the keyboard (https://wiki.ros.org/teleop_twist_keyboard)."""
