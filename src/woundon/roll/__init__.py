"""Pressure and stresses in a wound roll."""
