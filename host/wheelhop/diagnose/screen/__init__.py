"""Screening: what each effect could explain, to first order."""
