"""The rolling nip: one nonlinear system for web nips with and without wraps, and for rollers."""
