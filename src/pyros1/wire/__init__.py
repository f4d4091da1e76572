"""Converts bytes to values and back: connection headers, framing, send queues, handshake rules, HTTP and XML-RPC.

Nothing in this package uses a socket, a clock or the environment: bytes go in, values and bytes come out.
"""
