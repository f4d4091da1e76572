"""Nodes that most robots use, in folders named after their packages: joy, twist_mux, map_server and others.

Each folder is one package: pure logic, and a thin node around it with the original's parameters, topics and services.
The programs are in ``packages/``; the table in ``cli/package_scripts.py`` says which module each runs.
"""
