"""joy: publishes the state of a joystick (https://wiki.ros.org/joy)."""
