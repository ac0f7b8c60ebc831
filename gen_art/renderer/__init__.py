"""The renderer: from particles to linear light in a framebuffer, and from linear light to a picture (`develop`)."""

__all__ = []
