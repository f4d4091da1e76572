"""What nodes of robots share: parameters, a program that runs a node, and types of input and output."""
