"""EPFL's Cellulo robots: their bytes, EPFL's relay, the host's side of both, and an emulator that speaks them."""
