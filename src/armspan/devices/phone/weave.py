"""Sensors of one phone that each keep a time of their own, woven into one stream."""

from bisect import bisect_left, insort
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

from armspan.devices.phone.readings import attitude_between, between

LONGEST_NS = 1_000_000_000
"""A sensor that is silent for longer [ns] is not waited for."""
WARM_NS = 300_000_000
"""At first nobody knows which sensors there are; what the lead reads then [ns] is left out."""
MOST = 4000
"""Readings that are kept of each sensor."""

Values: TypeAlias = tuple[float, ...]


class Reading(NamedTuple):
    """What a sensor said at its time [ns]."""

    taken: int
    values: Values


class Weave:
    """Waits until all sensors have spoken past a time of the ``lead``, and says what they read then.

    Readings may come in any order within a batch; what lies between two readings is interpolated, four numbers as an
    attitude. A sensor that never spoke, or is a second behind, is left out.
    """

    def __init__(self, lead: str) -> None:
        self._lead = lead
        self._readings: dict[str, list[Reading]] = {}
        self._told = -1

    def put(self, sensor: str, taken: int, values: Sequence[float]) -> None:
        """Take a reading."""
        if not self._readings:
            self._told = taken + WARM_NS
        readings = self._readings.setdefault(sensor, [])
        reading = Reading(taken, tuple(values))
        if not readings or taken > readings[-1].taken:
            readings.append(reading)
        elif not _has(readings, taken):
            insort(readings, reading)
        if len(readings) > MOST:
            del readings[: MOST // 2]

    def take(self) -> list[tuple[int, dict[str, Values]]]:
        """Everything that is complete and was not told yet, in the order of time [ns]."""
        ready = []
        for taken, values in self._readings.get(self._lead, []):
            if taken <= self._told:
                continue
            others = {name: found for name in self._readings if name != self._lead for found in [self._at(name, taken)]}
            if any(found is _WAIT for found in others.values()):
                break
            self._told = taken
            ready.append((taken, {self._lead: values} | {name: found for name, found in others.items() if found}))
        self._forget()
        return ready

    def begin(self) -> None:
        """Forget everything: the phone's clock or its recording began anew."""
        self._readings.clear()
        self._told = -1

    def _at(self, sensor: str, taken: int) -> Values:
        """What a sensor read at a time: nothing where it was silent, ``_WAIT`` where it may still tell."""
        readings = self._readings[sensor]
        k = bisect_left(readings, taken, key=lambda reading: reading.taken)
        if k == len(readings):
            newest = self._readings[self._lead][-1].taken
            return _WAIT if newest - readings[-1].taken < LONGEST_NS else ()
        after = readings[k]
        if after.taken == taken:
            return after.values
        if k == 0 or after.taken - readings[k - 1].taken > LONGEST_NS:
            return ()
        before = readings[k - 1]
        share = (taken - before.taken) / (after.taken - before.taken)
        if len(after.values) == 4:
            return attitude_between(_four(before.values), _four(after.values), share)
        return between(before.values, after.values, share)

    def _forget(self) -> None:
        """Keep of each sensor the last reading before what was told, and what came after it."""
        for name, readings in self._readings.items():
            k = bisect_left(readings, self._told, key=lambda reading: reading.taken)
            del readings[: k if name == self._lead else max(0, k - 1)]


_WAIT: Values = (float("inf"),)


def _four(values: Values) -> tuple[float, float, float, float]:
    w, x, y, z = values
    return (w, x, y, z)


def _has(readings: list[Reading], taken: int) -> bool:
    k = bisect_left(readings, taken, key=lambda reading: reading.taken)
    return k < len(readings) and readings[k].taken == taken
