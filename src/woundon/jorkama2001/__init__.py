"""Reproduction of Jorkama (2001): figures and tables recomputed, statements of the text tested.

M. Jorkama, Contact mechanical model for winding nip (2001), called the thesis here.  The package
uses woundon as any program does, and in addition its sweeps and its panels.

    cases --> nips --> fig5 ... table4 (data, verdicts, panels) --> catalogue --> judgement
        --> publication (files)

``exhibits.toml`` lists the figures and tables.
"""
