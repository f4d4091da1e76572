"""The guide: from a first package to a robot, in steps. `text` has the steps, `checks` verifies their exercises."""
