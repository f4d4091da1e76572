"""Code that the robot nodes share: parameters, a program that runs a node, and inputs and outputs."""
