"""A server for rosbridge v2 with rosapi, for programs that use roslibjs or roslibpy."""
