"""Armspan: arms as a remote control for tabletop robots."""

__version__ = "0.1.0"
