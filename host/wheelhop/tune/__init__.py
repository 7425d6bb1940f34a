"""Tuning: which settings of a known car are best on the roads it drives, and how sure that is."""
