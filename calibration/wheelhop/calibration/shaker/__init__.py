"""Comparison with a reference on a shaker: two recorders, stepped or swept sines."""
