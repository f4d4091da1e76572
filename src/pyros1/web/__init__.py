"""Shows the running robot in a browser: the web server, its page, and the data that the page displays."""
