"""The tables of `tests/thorough/score`, one module each, and what they share."""
