"""Networking: the loop thread, XML-RPC server and clients, and the rules for host addresses."""
