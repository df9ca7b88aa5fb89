"""The sensing side of an emulated board: its three chips and its fusion, each on the board's own clock."""

import math
import struct
from collections.abc import Callable

import numpy as np

from armspan.devices.metawear.board_chips import (
    Chip,
    Feeling,
    Felt,
    acc_counts,
    acc_rate_hz,
    gyro_counts,
    gyro_rate_hz,
    mag_counts,
    mag_rate_hz,
)
from armspan.devices.metawear.board_fusion import CALIBRATION, NEEDED, OUTPUTS, RATES_HZ, Fusion
from armspan.devices.metawear.board_models import (
    ACC,
    ACC_REGISTERS,
    FUSION,
    GYRO,
    GYRO_REGISTERS,
    MAG,
    MAG_REGISTERS,
    Model,
    Traits,
)
from armspan.records import Vec3

Give = Callable[[int, int, bytes, float], None]
"""A source has data: module, register, payload, time [s]."""
SETTINGS_FROM = {0x0B: 1, 0x0C: 2, 0x0D: 2, 0x0E: 2, 0x0F: 3}
"""The revision of the fusion from which on a register exists."""
ORDER = (GYRO, MAG, ACC, FUSION)
"""Who comes first where several are due at once: a fuser on acc then finds the gyro of the same instant."""


class Sensing:
    """Chips and fusion; ``give`` is called with each set of data that they produce."""

    def __init__(
        self, model: Model, traits: Traits, generator: np.random.Generator, feeling: Feeling, give: Give
    ) -> None:
        self._model, self._traits, self._feeling, self._give = model, traits, feeling, give
        self.chips = {
            ACC: Chip(ACC_REGISTERS[model.implementation(ACC)]),
            GYRO: Chip(GYRO_REGISTERS[model.implementation(GYRO)]),
            MAG: Chip(MAG_REGISTERS),
        }
        self.fusion = Fusion(traits, generator)
        self.subscribed: set[tuple[int, int]] = set()
        self._stored: dict[tuple[int, int], bytes] = {}
        self._armed: dict[int, tuple[float, int]] = {}
        self._epoch = self._now = 0.0
        self._mag_cold, self._mag_stopped_at = model.revision(MAG) >= 2, math.inf

    # --- bytes --------------------------------------------------------------------------------------------

    def write(self, module: int, register: int, data: bytes) -> None:
        """A write to a register of acc, gyro, mag or fusion."""
        if register in self._streams(module):
            (self.subscribed.add if data[:1] == b"\x01" else self.subscribed.discard)((module, register))
        elif module == FUSION:
            self._write_fusion(register, data)
        elif register <= 0x03:
            self._switch_chip(module, register, data)
        else:
            self._stored[module, register] = data
        self._arm()

    def read(self, module: int, register: int) -> bytes | None:
        """What a register holds; None where there is nothing to answer."""
        if module != FUSION:
            return self.chips[module].config if register == 0x03 else self._stored.get((module, register))
        if self._model.revision(FUSION) < SETTINGS_FROM.get(register, 0):
            return None
        if register == 0x0B:
            return self.fusion.state()
        calibrated = {at: chip for chip, at in CALIBRATION.items()}
        if register in calibrated:
            return self.fusion.data(calibrated[register])
        held = {0x01: bytes([self.fusion.enabled]), 0x02: self.fusion.config, 0x03: bytes([self.fusion.mask, 0])}
        return held.get(register)

    def _streams(self, module: int) -> tuple[int, ...]:
        if module == FUSION:
            return tuple(OUTPUTS.values())
        registers = self.chips[module].registers
        if module == MAG and self._model.revision(MAG) < 1:
            return (registers.plain,)
        return registers.plain, registers.packed

    def _write_fusion(self, register: int, data: bytes) -> None:
        if self._model.revision(FUSION) < SETTINGS_FROM.get(register, 0) or not data:
            return
        calibrated = {at: chip for chip, at in CALIBRATION.items()}
        if register == 0x01:
            self.fusion.enable(data[0] == 1)
        elif register == 0x02:
            self.fusion.configure(data)
        elif register == 0x03:
            self.fusion.choose(data)
        elif register in calibrated:
            self.fusion.load(calibrated[register], data)
        elif register == 0x0F:
            self.fusion.level()

    def _switch_chip(self, module: int, register: int, data: bytes) -> None:
        if module == MAG and register == 0x01 and data:
            if data[0] == 0 and self._mag_stopped_at == math.inf:
                self._mag_stopped_at = self._now
            elif data[0] == 1 and self._now - self._mag_stopped_at >= self._traits.mag_settle_s:
                self._mag_cold = False
        self.chips[module].switch(register, data)

    # --- time ---------------------------------------------------------------------------------------------

    def begin(self, t: float) -> None:
        """The board was switched on at ``t`` [s]."""
        self._epoch, self._now = t, 0.0

    def advance(self, t: float) -> None:
        """Produce everything up to ``t`` [s], in order."""
        until = (t - self._epoch) * (1.0 + self._traits.drift)
        while (first := self._first()) is not None and first[0] <= until + 1e-9:
            at, module = first
            rate, number = self._armed[module]
            self._armed[module] = (rate, number + 1)
            self._now = at
            self._sample(module, self._host_time(at))
        self._now = max(self._now, until)

    def due(self) -> float | None:
        """When the next sample is taken [s]."""
        first = self._first()
        return None if first is None else self._host_time(first[0])

    def _host_time(self, board_time: float) -> float:
        return self._epoch + board_time / (1.0 + self._traits.drift)

    def _first(self) -> tuple[float, int] | None:
        times = [(self._armed[module][1] / self._armed[module][0], module) for module in ORDER if module in self._armed]
        return min(times, key=lambda pair: pair[0], default=None)

    def _arm(self) -> None:
        """Who runs now, at which rate, and when it samples next."""
        rates = self._rates()
        self._armed = {
            module: self._armed[module]
            if module in self._armed and self._armed[module][0] == rate
            else (rate, math.floor(self._now * rate + 1e-9) + 1)
            for module, rate in rates.items()
        }

    def _rates(self) -> dict[int, float]:
        """Fusion and raw data do not go together: while the fusion is on, nothing raw comes."""
        rates = {ACC: acc_rate_hz, GYRO: gyro_rate_hz, MAG: mag_rate_hz}
        raw = {module: rates[module](chip) for module, chip in self.chips.items() if chip.running}
        mode = self.fusion.mode
        if not self.fusion.enabled or mode not in NEEDED:
            return raw
        if self.fusion.crashed or any(module not in raw for module in NEEDED[mode]):
            return {}
        return {FUSION: min(RATES_HZ[mode], raw[ACC])}

    # --- data ---------------------------------------------------------------------------------------------

    def _sample(self, module: int, t: float) -> None:
        felt = self._feeling.at(t)
        if module == FUSION:
            self._fuse(felt, t)
            return
        chip, counts = self.chips[module], struct.pack("<3h", *self._counts(module, felt))
        self._give(module, chip.registers.plain, counts, t)
        if (module, chip.registers.packed) in self.subscribed and (three := chip.three(counts)) is not None:
            self._give(module, chip.registers.packed, three, t)

    def _counts(self, module: int, felt: Felt) -> tuple[int, int, int]:
        if module == ACC:
            return acc_counts(self.chips[ACC], felt.acc)
        if module == GYRO:
            return gyro_counts(self.chips[GYRO], felt.gyr)
        return (0, 0, 0) if self._mag_cold else mag_counts(felt.mag)

    def _fuse(self, felt: Felt, t: float) -> None:
        fusion = self.fusion
        seconds = 1.0 / self._armed[FUSION][0]
        fusion.run(seconds)
        quat = fusion.attitude(felt, seconds)
        acc, gyr, mag = (_floats(self._counts(module, felt)) for module in (ACC, GYRO, MAG))
        for bit, register in OUTPUTS.items():
            if fusion.mask & bit:
                self._give(FUSION, register, fusion.output(register, quat, acc, gyr, mag), t)


def _floats(counts: tuple[int, int, int]) -> Vec3:
    x, y, z = counts
    return float(x), float(y), float(z)
