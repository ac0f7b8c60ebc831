"""How the particles of one system are stored."""
