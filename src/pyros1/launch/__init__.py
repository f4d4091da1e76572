"""Launch files: XML to a plan, and a plan to running, supervised processes (https://wiki.ros.org/roslaunch)."""
