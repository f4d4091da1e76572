"""Diagnosis of a ROS system: collectors gather facts, and checks without side effects derive findings from them."""
