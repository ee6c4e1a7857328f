"""The interactive page in the browser, ``woundon app``, and its HTTP API."""
