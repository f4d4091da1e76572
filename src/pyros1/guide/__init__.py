"""The guide: an introduction in steps, from a first package to a robot. `checks` verifies the exercises."""
