"""Diagnosis of a ROS system: collectors gather facts, and pure checks derive findings with hints from them."""
