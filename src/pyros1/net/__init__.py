"""Sockets: the loop thread, XML-RPC server and clients, host and environment rules."""
