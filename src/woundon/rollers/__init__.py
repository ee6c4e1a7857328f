"""Two rollers in contact without a web: the textbook's problems by the nip's contact code."""
