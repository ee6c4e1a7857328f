"""Case files, result files, tables and chosen units."""
