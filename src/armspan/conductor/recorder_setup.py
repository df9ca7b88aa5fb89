"""The set-up of a recording: how the bands sit and where the user's front is; no robot is needed."""

from collections.abc import Mapping
from dataclasses import dataclass

from armspan.conductor.setup import RESTED, SetUp, Step
from armspan.orientation import Hold
from armspan.records import Output, RobotState, Say


@dataclass(slots=True)
class WristSetUp(SetUp):
    """The first poses of the set-up, asked and judged exactly as for pointing, so that both give one user frame."""

    @property
    def robot(self) -> str:
        """No robot takes part."""
        return ""

    @property
    def ready(self) -> bool:
        """Whether all bands are mounted."""
        return self.step is Step.IDLE and all(band.mount is not None for band in self.arm.bands)

    def begin(self, t: float) -> list[Output]:
        """Start, or start again."""
        for band in self.arm.bands:
            band.mount = None
        if not any(band.raw for band in self.arm.bands):
            return self._ask_to_stretch(t)
        asked = self._ask(t, Step.REST, f"Rest {self._arms} on your lap or the table, quite still", "rest")
        self._holds = {band.settings.name: Hold(needed=RESTED) for band in self.arm.bands}
        return asked

    def tick(self, t: float, states: Mapping[str, RobotState]) -> list[Output]:
        """Take what the arms do at ``t`` [s]; the last step mounts the bands."""
        return [] if self.ready else SetUp.tick(self, t, states)

    def _next_stop(self, t: float) -> list[Output]:
        self.step = Step.IDLE
        return [Say(t, "The bands are set up: your front is where you stretched your arms", "mounted")]
