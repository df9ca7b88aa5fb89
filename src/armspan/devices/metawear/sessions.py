"""Whole sessions with a MetaWear board, as steps in the order in which the vendor's library writes them.

Source: bytes of MbientLab's library 0.21.0 run against a scripted board.
"""

from collections.abc import Callable, Sequence
from typing import TypeAlias

from armspan.devices.metawear import programs, settings, wire
from armspan.devices.metawear.boards import Board

Steps: TypeAlias = tuple[tuple[str, tuple[bytes, ...]], ...]
"""Titles and writes."""


def fusion_start_stop(mode: str, outputs: Sequence[str]) -> Steps:
    """Start the fusion and stop it."""
    return ("start", wire.start_fusion(mode, outputs)), ("stop", wire.stop_fusion(mode))


def fusion_session(board: Board, mode: str, outputs: Sequence[str], range_g: float, range_dps: float) -> Steps:
    """From connection to its end with outputs of the fusion and the button."""
    return (
        ("connection parameters", (settings.connection_parameters(*settings.STREAMING),)),
        ("fusion config", wire.configure_fusion(board, mode, range_g, range_dps)),
        ("subscribe outputs", tuple(wire.subscribe(board, output) for output in outputs)),
        ("subscribe switch", (wire.subscribe(board, "switch"),)),
        ("enable + start", wire.start_fusion(mode, outputs)),
        ("stop", wire.stop_fusion(mode)),
        ("unsubscribe outputs", tuple(wire.unsubscribe(board, output) for output in outputs)),
        ("unsubscribe switch", (wire.unsubscribe(board, "switch"),)),
        ("disconnect", (wire.DISCONNECT,)),
    )


def raw_session(*, packed: bool) -> Callable[..., Steps]:
    """Acceleration and angular velocity as the chips give them, three samples a packet or one."""
    streams = ("acc_packed", "gyro_packed") if packed else ("acc", "gyro")

    def steps(board: Board, range_g: float, rate_hz: float, range_dps: float, gyro_hz: float) -> Steps:
        return (
            ("acc config", (wire.configure_acc(board, rate_hz, range_g),)),
            ("gyro config", (wire.configure_gyro(board, gyro_hz, range_dps),)),
            ("subscribe", tuple(wire.subscribe(board, stream) for stream in streams)),
            ("enable", tuple(map(wire.enable_sampling, _CHIPS))),
            ("start", tuple(map(wire.start, _CHIPS))),
            ("stop", (*_halt(), *(wire.unsubscribe(board, stream) for stream in streams))),
        )

    return steps


def fused_session(board: Board, rate_hz: float, range_g: float, range_dps: float) -> Steps:
    """Acceleration and angular velocity of one instant with the board's clock."""
    keep, fuse, account = programs.fused_raw(board)
    configs = (wire.configure_acc(board, rate_hz, range_g), wire.configure_gyro(board, rate_hz, range_dps))
    return (
        ("acc + gyro config", configs),
        ("create fuser (the board answers 090200 and 090201)", (keep, fuse)),
        ("create accounter, time mode (the board answers 090202)", (account,)),
        ("subscribe to the accounter", programs.subscribe_processor(2)),
        ("enable + start", (*map(wire.enable_sampling, _CHIPS[::-1]), *map(wire.start, _CHIPS[::-1]))),
        ("stop", _halt()),
        ("unsubscribe", programs.unsubscribe_processor(2)),
        ("tear down", programs.TEAR_DOWN),
    )


_CHIPS = ("acc", "gyro")


def _halt() -> tuple[bytes, ...]:
    return *map(wire.stop, _CHIPS), *map(wire.disable_sampling, _CHIPS)
