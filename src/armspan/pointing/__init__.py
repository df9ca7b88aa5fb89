"""Attitude to ray to place or robot; pairs of ray and robot to where the user is."""
