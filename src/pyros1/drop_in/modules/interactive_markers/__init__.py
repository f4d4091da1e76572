"""interactive_markers, by pyros1: markers in RViz that the user can move (https://wiki.ros.org/interactive_markers)."""
