"""ParameterGenerator under its name in rosbuild; see `dynamic_reconfigure.parameter_generator_catkin`."""

from dynamic_reconfigure.parameter_generator_catkin import (
    LINEDEBUG,
    ParameterGenerator,
    bool_t,
    check_description,
    check_name,
    double_t,
    id,
    inspect,
    int_t,
    os,
    re,
    str_t,
    sys,
)

__all__ = [
    "LINEDEBUG",
    "ParameterGenerator",
    "bool_t",
    "check_description",
    "check_name",
    "double_t",
    "id",
    "inspect",
    "int_t",
    "os",
    "re",
    "str_t",
    "sys",
]
