"""The server: who comes in, files, sockets, the page's protocol, and the threads that do what takes time."""
