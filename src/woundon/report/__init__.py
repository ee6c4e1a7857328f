"""Results shown to people: reports and figures."""
