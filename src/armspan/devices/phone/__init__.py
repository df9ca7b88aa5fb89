"""Phones and watches as bands: Sensor Logger, SensorServer, and a page of our own."""
