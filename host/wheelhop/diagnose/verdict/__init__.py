"""The verdict: what was found, what it is worth, and what is odd about it."""
