"""The nip and the roll in the browser: ``woundon app``, and what it answers over HTTP."""
