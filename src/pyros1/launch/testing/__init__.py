"""Running the tests of launch files."""
