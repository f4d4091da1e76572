"""ParameterGenerator under the name of rosbuild's times; see `dynamic_reconfigure.parameter_generator_catkin`."""

from dynamic_reconfigure.parameter_generator_catkin import (
    LINEDEBUG,
    ParameterGenerator,
    bool_t,
    check_description,
    check_name,
    double_t,
    id,
    int_t,
    str_t,
)

__all__ = [
    "LINEDEBUG",
    "ParameterGenerator",
    "bool_t",
    "check_description",
    "check_name",
    "double_t",
    "id",
    "int_t",
    "str_t",
]
