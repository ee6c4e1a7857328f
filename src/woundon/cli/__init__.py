"""The command line ``woundon``: one module for each command, or for a few related ones."""
