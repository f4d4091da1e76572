"""Diagnostics of a node, like stock's Python module (https://wiki.ros.org/diagnostic_updater)."""

import threading

import rospy

from diagnostic_updater._diagnostic_status_wrapper import (
    ERROR,
    OK,
    WARN,
    DiagnosticStatus,
    DiagnosticStatusWrapper,
    KeyValue,
)
from diagnostic_updater._diagnostic_updater import (
    CompositeDiagnosticTask,
    DiagnosticArray,
    DiagnosticTask,
    DiagnosticTaskVector,
    FunctionDiagnosticTask,
    Updater,
)
from diagnostic_updater._publisher import DiagnosedPublisher, HeaderlessTopicDiagnostic, TopicDiagnostic
from diagnostic_updater._update_functions import (
    FrequencyStatus,
    FrequencyStatusParam,
    Heartbeat,
    TimeStampStatus,
    TimeStampStatusParam,
)

__all__ = [
    "ERROR",
    "OK",
    "WARN",
    "CompositeDiagnosticTask",
    "DiagnosedPublisher",
    "DiagnosticArray",
    "DiagnosticStatus",
    "DiagnosticStatusWrapper",
    "DiagnosticTask",
    "DiagnosticTaskVector",
    "FrequencyStatus",
    "FrequencyStatusParam",
    "FunctionDiagnosticTask",
    "HeaderlessTopicDiagnostic",
    "Heartbeat",
    "KeyValue",
    "TimeStampStatus",
    "TimeStampStatusParam",
    "TopicDiagnostic",
    "Updater",
    "rospy",  # in stock ROS, too, `import *` provides this name and the next
    "threading",
]
