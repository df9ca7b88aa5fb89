"""When samples were measured, told from their arrival over radios that deliver in bursts: our clocks, two plain ones.

Simulated. A band measures at 100 Hz nominally, a radio hands over at each connection event what was measured since the
last one (an exponential delay of 1 ms more, in order), some packets are lost. From the same arrivals, in the same run:
`DeviceClock` with the device's 32-bit ticks of 48/32768 s, whose crystal is 20 ppm fast; `StreamClock` without ticks;
"arrival", for which a sample was measured when it came; "nominal", which starts at the first arrival and goes on by the
device's ticks, or by 10 ms a sample that came. An error is told minus true time; the first two seconds stand apart.
Run: python benchmarks/clocks.py
Prints Markdown tables.
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from armspan.clock import DeviceClock, StreamClock
from armspan.frames import Array

TICK, BITS, CRYSTAL = 48 / 32768, 32, 20e-6
"""A tick of a MetaWear board [s], its counter's width, and how much faster than told it counts."""
SPACING = 0.01
FIRST = 2.0
"""What stands apart [s]: nothing can be known of the delays yet."""
EVENT_DELAY = 0.001
"""Mean of what a connection event is late by [s], drawn anew for each."""
STALLED, STALL = 0.02, (0.01, 0.06)
"""The share of connection events that come later, and by how much [s]."""
RATES = (100.0, 99.0, 100.5)


@dataclass(frozen=True, slots=True)
class Radio:
    """How packets are handed over: the range [s] of the time between events (0: at once), and whether some stall."""

    interval: tuple[float, float] = (0.0, 0.0)
    stalls: bool = False


RADIOS = {
    "at once": Radio(),
    "7.5 ms": Radio((0.0075, 0.0075)),
    "30 ms": Radio((0.03, 0.03)),
    "40 ms": Radio((0.04, 0.04)),
    "48.75 ms": Radio((0.04875, 0.04875)),
    "50 ms": Radio((0.05, 0.05)),
    "30 to 50 ms, irregular": Radio((0.03, 0.05)),
    "50 ms, 2 % stalled": Radio((0.05, 0.05), stalls=True),
}


@dataclass(frozen=True, slots=True)
class Stream:
    """What came of a stream: times measured and arrived [s], the device's ticks, and how many packets did not come."""

    measured: Array
    arrived: Array
    ticks: list[int]
    lost: int


Told = tuple[Array, int | None]
"""Times [s], and how many samples a way holds for lost where it has an opinion."""


def streamed(radio: Radio, rate: float, loss: float, seconds: float, rng: np.random.Generator) -> Stream:
    """A stream over a radio."""
    measured = 5.0 + rng.uniform() + np.arange(round(seconds * rate)) / rate
    arrived = np.maximum.accumulate(_handed_over(radio, measured, rng))
    came = rng.random(len(measured)) >= loss
    ticks = np.floor((measured + rng.uniform(0.0, 1000.0)) * (1.0 + CRYSTAL) / TICK).astype(int) % (1 << BITS)
    return Stream(measured[came], arrived[came], ticks[came].tolist(), int((~came).sum()))


def _handed_over(radio: Radio, measured: Array, rng: np.random.Generator) -> Array:
    low, high = radio.interval
    if high == 0.0:
        return measured + EVENT_DELAY + rng.exponential(EVENT_DELAY, len(measured))
    count = int((measured[-1] - measured[0] + 1.0) / low) + 2
    events = measured[0] + rng.uniform(-low, 0.0) + np.cumsum(rng.uniform(low, high, count))
    late = rng.exponential(EVENT_DELAY, count)
    if radio.stalls:
        late += np.where(rng.random(count) < STALLED, rng.uniform(*STALL, count), 0.0)
    event = np.searchsorted(events, measured)
    return events[event] + late[event]


def by_arrival(stream: Stream) -> Told:
    return stream.arrived, None


def by_device_clock(stream: Stream) -> Told:
    clock = DeviceClock(TICK, bits=BITS, spacing=SPACING)
    return np.array([clock.seconds(*pair) for pair in zip(stream.ticks, stream.arrived.tolist(), strict=True)]), None


def by_nominal_ticks(stream: Stream) -> Told:
    ticks = np.array(stream.ticks)
    return stream.arrived[0] + (ticks - ticks[0]) % (1 << BITS) * TICK, None


def by_stream_clock(stream: Stream) -> Told:
    clock = StreamClock(SPACING)
    return np.array([clock.seconds(arrived) for arrived in stream.arrived.tolist()]), clock.lost


def by_nominal_rate(stream: Stream) -> Told:
    return stream.arrived[0] + np.arange(len(stream.arrived)) * SPACING, None


Way = Callable[[Stream], Told]
WITH_TICKS: dict[str, Way] = {"DeviceClock": by_device_clock, "arrival": by_arrival, "nominal": by_nominal_ticks}
WITHOUT: dict[str, Way] = {"StreamClock": by_stream_clock, "arrival": by_arrival, "nominal": by_nominal_rate}


def cells(way: Way, streams: list[Stream]) -> list[str]:
    """A way's errors over all streams, and what it counted as lost."""
    early, later, lost = [], [], []
    for stream in streams:
        told, counted = way(stream)
        if np.diff(told).min() < 0.0:
            raise ValueError("times fall")
        first = stream.measured < stream.measured[0] + FIRST
        early.append((told - stream.measured)[first])
        later.append((told - stream.measured)[~first])
        lost.append(counted)
    columns = [_percentiles(np.concatenate(later)), _percentiles(np.concatenate(early))]
    if way is by_stream_clock:
        columns.append(f"{sum(lost)} of {sum(stream.lost for stream in streams)}")
    return columns


def _percentiles(errors: Array) -> str:
    sizes = 1000 * np.abs(errors)
    return " / ".join(f"{value:.1f}" for value in (*np.percentile(sizes, [50, 95]), sizes.max()))


def table(ways: dict[str, Way], loss: float, args: argparse.Namespace) -> None:
    """One row for each radio and rate."""
    ours, *others = ways
    counts = ours == "StreamClock"
    print(f"\n{ours}, {100 * loss:g} % of the packets lost; errors in ms, p50 / p95 / max of their size\n")
    heads = ["delivered", "Hz", ours, "first 2 s"] + ["counted as lost"] * counts
    heads += [head for name in others for head in (name, "first 2 s")]
    print(f"| {' | '.join(heads)} |\n" + "|---" * len(heads) + "|")
    for name, radio in RADIOS.items():
        for rate in RATES:
            dice = [np.random.default_rng((args.first + k, round(10 * rate))) for k in range(args.seeds)]
            streams = [streamed(radio, rate, loss, args.seconds, rng) for rng in dice]
            row = [cell for way in ways.values() for cell in cells(way, streams)]
            print(f"| {name} | {rate:g} | {' | '.join(row)} |", flush=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=6, help="streams of each kind; default: %(default)s")
    parser.add_argument("--first", type=int, default=0, help="the first seed; default: %(default)s")
    parser.add_argument("--seconds", type=float, default=120.0, help="of each stream; default: %(default)s")
    parser.add_argument("--loss", type=float, nargs="*", default=[0.0, 0.01], help="shares; default: 0 and 0.01")
    args = parser.parse_args()
    print(f"{args.seeds} streams of {args.seconds:g} s in each row, seeds from {args.first} on")
    for ways in (WITH_TICKS, WITHOUT):
        for loss in args.loss:
            table(ways, loss, args)
    return 0


if __name__ == "__main__":
    sys.exit(main())
