"""Serves programs that use roslibjs or roslibpy: implements rosbridge v2 and rosapi."""
