"""Transfer matrices from data."""
