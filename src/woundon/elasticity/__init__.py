"""Closed elastic solutions of the bodies (thesis ch. 2): pure functions, arrays in and out."""
