"""The storage of the particles of one system."""
