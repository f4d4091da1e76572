"""tf2_kdl is left out: it converts to and from types of PyKDL, a compiled library."""

raise ImportError(
    "pyros1 has no tf2_kdl: it converts types of PyKDL, a compiled library. "
    "tf2_geometry_msgs transforms messages without it"
)
