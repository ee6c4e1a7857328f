"""Winding: the nip's tension as the roll grows, the roll that it leaves, and whether it holds."""
