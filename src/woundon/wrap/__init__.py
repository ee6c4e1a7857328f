"""The web wrapped on the roll behind the nip and on the drum before it (thesis sec. 3.5)."""
