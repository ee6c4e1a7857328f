"""Studies over any solver: sweeps, fits, global sensitivity; callables and tables, no physics.

    inputs and their values --> Design --> chunks --> runner (here, pool, Dask) --> store, Table

``nip`` binds woundon's own solvers to it; it and the command line are all that know physics.
"""
