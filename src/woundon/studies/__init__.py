"""Studies over any kind of problem: sweeps, fits, global sensitivity; they contain no physics.

    inputs and their values --> Cases --> run_study: chunks, workers, store --> Table

A study uses a ``Model`` only: names in, numbers out; ``KindModel`` is that of any kind of problem.
``api`` contains the public functions.
"""
