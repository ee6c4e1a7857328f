"""The stresses that winding leaves in a roll."""
