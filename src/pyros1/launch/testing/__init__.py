"""Runs the tests in launch files."""
