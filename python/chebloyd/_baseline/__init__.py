"""The native half for every processor."""
