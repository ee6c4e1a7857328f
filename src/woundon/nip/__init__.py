"""The winding nip alone, the web held to the roll at its trailing edge (thesis ch. 3)."""
