"""The search over sets of effects: add, drop, exchange, several together."""
