"""rosbridge v2 with rosapi, for programs of roslibjs and roslibpy."""
