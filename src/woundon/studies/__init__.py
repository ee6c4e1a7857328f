"""Studies over any kind of problem: sweeps, fits, global sensitivity; they know no physics.

    inputs and their values --> Design --> chunks --> runner (here, pool, Dask) --> store, Table

The engine knows a ``Model`` only: names in, numbers out.  ``kind_model`` makes one of a problem of
any kind; ``api`` and ``commands`` are what people call.
"""
