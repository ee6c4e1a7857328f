"""Air that comes in with the web: what nip and wrap let through, and what it does to friction."""
