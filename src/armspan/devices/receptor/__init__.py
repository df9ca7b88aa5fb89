"""Receptors: whatever a lab soldered that notices a laser's spot on a robot, and says so in lines of text."""
