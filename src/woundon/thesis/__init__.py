"""The figures and tables of Jorkama's thesis (2001), recomputed; a module each."""
