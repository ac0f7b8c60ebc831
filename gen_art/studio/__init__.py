"""The studio: a page in the browser in which a preset is seen while it is changed."""
