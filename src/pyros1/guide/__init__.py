"""The guide: from a first package to a robot, in steps. `text` has the steps, `checks` what their exercises ask for."""
