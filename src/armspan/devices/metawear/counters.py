"""What a band's streams went through: samples, losses, gaps, reconnections."""

from collections import deque
from dataclasses import dataclass, field

GAPS = 10_000
"""Gaps that are kept; older ones are only counted."""


@dataclass(frozen=True, slots=True)
class Gap:
    """``samples`` are missing in the ``seconds`` before session time ``t`` [s]."""

    t: float
    seconds: float
    samples: int


@dataclass(slots=True)
class StreamCounters:
    """One stream: samples that came, samples that did not, packets that made no sense, and every gap."""

    samples: int = 0
    lost: int = 0
    refused: int = 0
    gaps: int = 0
    latest_gaps: deque[Gap] = field(default_factory=lambda: deque(maxlen=GAPS))

    def gap(self, t: float, seconds: float, samples: int) -> None:
        """Samples are missing before the one at ``t`` [s]."""
        self.lost += samples
        self.gaps += 1
        self.latest_gaps.append(Gap(t, seconds, samples))

    def take_back(self, samples: int) -> None:
        """Samples of the latest gaps were not lost after all."""
        self.lost -= samples
        while samples > 0 and self.latest_gaps:
            last = self.latest_gaps.pop()
            left = max(0, last.samples - samples)
            samples -= last.samples - left
            if left:
                self.latest_gaps.append(Gap(last.t, last.seconds, left))
            else:
                self.gaps -= 1


@dataclass(slots=True)
class Report:
    """What one band went through, for people: ``trouble`` is why it is not there now, in a sentence."""

    name: str
    address: str
    board: str = ""
    firmware: str = ""
    mac: str | None = None
    battery: float | None = None
    up: bool = False
    connections: int = 0
    resumed: int = 0
    links_lost: int = 0
    restarts: int = 0
    resets: int = 0
    accuracy: tuple[int, int, int] | None = None
    calibration: str = "none"
    trouble: str = ""
    notes: list[str] = field(default_factory=list)
    streams: dict[str, StreamCounters] = field(default_factory=dict)
