"""The only place that starts Taichi or knows its inside."""
