"""The server: access control, files, sockets, the page's protocol, and the threads for slow work."""
