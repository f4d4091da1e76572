"""The nodes of the package rostest: each looks at a running system, and writes what it found as JUnit XML (L186)."""
