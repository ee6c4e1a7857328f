"""Jorkama (2001), reproduced: figures and tables recomputed with woundon, the text's claims tested.

M. Jorkama, Contact mechanical model for winding nip (2001), called the thesis here.  The package
uses woundon as any program does; what it still needs from within stands in ``inside``.

    cases --> nips --> fig5 ... table4 (data, verdicts, drawing) --> exhibits --> publication
"""
