"""What decided in a session that was logged, made anew from its log."""

import msgspec

from armspan.conductor import Conductor, Settings
from armspan.conductor.robots_only import RobotsOnly
from armspan.config.model_files import from_header
from armspan.config.record_room import recorder_of
from armspan.errors import ConfigError, LogError
from armspan.log import LogFile
from armspan.session import Mind


def settings_of(log: LogFile) -> Settings:
    """The settings in a log's header.

    Raises:
        LogError: when they are not those of this version.

    """
    try:
        return msgspec.convert(log.header.get("settings"), Settings)
    except (msgspec.ValidationError, ConfigError) as error:
        raise LogError(
            f"{log.path} has settings that this version of Armspan does not know ({error}): replay it with "
            f"version {log.header.get('armspan', 'that wrote it')}"
        ) from None


def mind_of(log: LogFile, settings: Settings) -> Mind:
    """A conductor, the recorder of a recording, or where there is no band the mind of `armspan swarm`.

    Raises:
        LogError: a recording that this version of Armspan does not know.
        ModelError: a gesture model that it does not know.

    """
    recorder = recorder_of(log, settings)
    if recorder is not None:
        return recorder
    return Conductor(settings, from_header(log.header)) if settings.bands else RobotsOnly(settings)
