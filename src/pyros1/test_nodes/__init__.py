"""The nodes of the package rostest: each checks a running system, and writes its results in a JUnit XML file (L186)."""
