"""The gallery: a page that shows a still and a loop of each shipped preset, from the file system alone."""
