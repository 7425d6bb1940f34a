"""Confirmation: effects simulated and fitted in full, and judged on runs held out."""
