"""The discrete contact problem (thesis sec. 3.4, 3.6): arrays in, arrays out, no physics."""
