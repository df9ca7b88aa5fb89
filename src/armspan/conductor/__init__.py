"""The one mind, pure: ``step(event) -> [outputs]``."""

from armspan.conductor.conductor import Conductor
from armspan.conductor.settings import BandSettings, Settings

__all__ = ["BandSettings", "Conductor", "Settings"]
