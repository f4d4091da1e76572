"""teleop_twist_joy: drives a robot with a joystick (https://wiki.ros.org/teleop_twist_joy)."""
