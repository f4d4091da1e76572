"""The nodes of the package rostest: each checks a running system and writes the results as JUnit XML (L186)."""
