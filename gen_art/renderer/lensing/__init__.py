"""Light that a wormhole bends: its geodesics, where a camera stands in it, and the images of sky, stars and particles."""
