"""Pictures and films as files, each with its recipe inside."""

__all__ = []
