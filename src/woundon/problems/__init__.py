"""What is described: materials, bodies, and the problems that are solved; immutable, validated."""
