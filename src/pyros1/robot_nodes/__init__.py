"""The everyday nodes of robots, by the names of their packages: joy, twist_mux, map_server and others.

Each folder is one package: pure logic, and a thin node around it that has the parameters, topics and services of the
original. The programs are in ``packages/``; the table in ``cli/package_scripts.py`` says which module each runs.
"""
