"""Every command of a MetaWear board by its published name: those without arguments, and the rules for the others."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

from armspan.devices.metawear import boards, programs, settings, signals, wire
from armspan.devices.metawear.boards import Board
from armspan.devices.metawear.name_forms import Rule, Writes
from armspan.devices.metawear.quantities import OUTPUTS, counts
from armspan.devices.metawear.sessions import fused_session, fusion_session, fusion_start_stop, raw_session
from armspan.devices.metawear.usb_frames import usb_frame

VECTOR_LED: Final = {"delay_ms": 5000, "repeat": 10}
"""What a LED's name with a revision means beside it."""


TIMER_EXAMPLE: Final = {"period_ms": 2718281828, "repeat": 45904, "channel": 1}
"""The published one, for a name that tells none."""
CALIBRATION: Final[Mapping[str, str]] = {
    "acc": "f6ff00000a00e8030300",
    "gyro": "04000800010000000300",
    "mag": "660017fd8afc7f030100",
}
"""A board's published calibration data, for names that tell none."""


_STREAM_PATHS: Final = {
    "switch": "switch",
    "acc": "acc",
    "acc.packed": "acc_packed",
    "acc.tap": "tap",
    "acc.gesture": "gesture",
    "acc.activity": "activity",
    "gyro": "gyro",
    "gyro.packed": "gyro_packed",
    "mag": "mag",
    "mag.packed": "mag_packed",
    "settings.power_status": "power_status",
    "settings.charge_status": "charge_status",
}
_READINGS: Final = {
    "acc": {"config": "acc_config"},
    "gyro": {"config": "gyro_config"},
    "fusion": {"config": "fusion_config", "calibration_state": "calibration_state"},
    "settings": {word: word for word in ("battery", "mac", "power_status", "charge_status")},
    "logging": {"time": "log_time", "length": "log_length"},
    "switch": {"state": "switch"},
}
_READ_PATHS: Final = {
    form.format(module, word): what
    for module, readings in _READINGS.items()
    for word, what in readings.items()
    for form in ("{}.read_{}", "{}.{}.read")
}


def _plain() -> dict[str, Callable[[Board], Writes]]:
    """Names without arguments."""
    fixed: dict[str, Writes] = {
        "debug.reset": wire.RESET,
        "debug.bootloader": wire.BOOTLOADER,
        "debug.jump_to_bootloader": wire.BOOTLOADER,
        "debug.reset_after_gc": wire.RESET_AFTER_GC,
        "debug.disconnect": wire.DISCONNECT,
        "debug.power_save": wire.POWER_SAVE,
        "debug.enable_power_save": wire.POWER_SAVE,
        "settings.start_advertising": wire.ADVERTISE,
        "acc.tap.disable": b"\x03\x0c\x00\x03",
        "fusion.calibration_data.read_chain": (b"\x19\x8c", b"\x19\x8d", b"\x19\x8e"),
        "switch.read": wire.read("switch"),
        "tear_down": programs.TEAR_DOWN,
        "teardown": programs.TEAR_DOWN,
        "factory_clean": programs.FACTORY_CLEAN,
        "logging.start": programs.START_LOGGING,
        "logging.stop": programs.STOP_LOGGING,
        "logging.clear_entries": programs.CLEAR_LOG,
        "logging.remove_all_loggers": programs.REMOVE_LOGGERS,
        "logging.flush_page": programs.FLUSH_PAGE,
        "logging.ask": programs.ASK_LOG,
        "logging.confirm_page": programs.CONFIRM_PAGE,
        "handshake": (*map(wire.ask_module, boards.MODULES), wire.read("log_time")),
        **{f"led.{word}": order for word, order in signals.LED_PLAYS.items()},
        **{path: wire.read(what) for path, what in _READ_PATHS.items()},
    }
    for sensor in wire.SENSORS:
        for deed in (wire.enable_sampling, wire.disable_sampling, wire.start, wire.stop):
            fixed[f"{sensor}.{deed.__name__}"] = deed(sensor)
    return {name: _always(writes) for name, writes in fixed.items()} | _of_boards()


def _of_boards() -> dict[str, Callable[[Board], Writes]]:
    """Names without arguments whose bytes depend on the board."""
    plain: dict[str, Callable[[Board], Writes]] = {
        "acc.tap.enable_single": wire.enable_taps,
        "acc.tap.enable_double": partial(wire.enable_taps, single=False, double=True),
        "acc.tap.enable_both": partial(wire.enable_taps, double=True),
        "mag.suspend": wire.suspend_mag,
        "fusion.reset_orientation": wire.reset_orientation,
        "settings.force_1m_phy": settings.force_1m_phy,
        "settings.force_1m_phy.on": settings.force_1m_phy,
        "settings.force_1m_phy.off": partial(settings.force_1m_phy, on=False),
        "settings.3v_regulator": settings.supply_3v,
        "settings.3v_regulator.on": settings.supply_3v,
        "settings.3v_regulator.off": partial(settings.supply_3v, on=False),
        "settings.enable_3v_regulator": settings.supply_3v,
        "settings.disable_3v_regulator": partial(settings.supply_3v, on=False),
        "processor.fuser_chain": programs.limited_chain,
    }
    paths = _STREAM_PATHS | {f"fusion.{output}": output for output in OUTPUTS}
    for path, stream in paths.items():
        plain[f"{path}.subscribe"] = partial(wire.subscribe, stream=stream)
        plain[f"{path}.unsubscribe"] = partial(wire.unsubscribe, stream=stream)
    for output in OUTPUTS:
        plain[f"fusion.subscribe.{output}"] = plain[f"fusion.{output}.subscribe"]
        plain[f"fusion.unsubscribe.{output}"] = plain[f"fusion.{output}.unsubscribe"]
    for feature in wire.FEATURES:
        plain[f"acc.{feature}.enable"] = partial(wire.switch_feature, feature=feature, on=True)
        plain[f"acc.{feature}.disable"] = partial(wire.switch_feature, feature=feature, on=False)
    return plain


def _always(writes: Writes) -> Callable[[Board], Writes]:
    """An encoder of the same bytes for every board."""
    return lambda board: writes


def _of(function: Callable[..., Writes]) -> Callable[..., Writes]:
    """An encoder that needs no board."""
    return lambda board, **args: function(**args)


def _buzz(seconds: float) -> Writes:
    """Let the motor tell of a lost link."""
    return programs.on_disconnect((signals.motor(100, round(seconds * 1000)),))


def _account(board: Board, stream: str, *, count: bool) -> Writes:
    return programs.accounter(programs.stream_source(board, stream), count=count)


def _limit(board: Board, stream: str, period_ms: int) -> Writes:
    return programs.rate_limiter(programs.stream_source(board, stream), period_ms)


def _log(board: Board, stream: str) -> Writes:
    return programs.log(programs.stream_source(board, stream))


def _flash(board: Board, colour: str, preset: str, repeat: int) -> Writes:
    """Let the LED tell of a lost link."""
    pattern = signals.led_preset(board, preset, colour, repeat=repeat)
    return programs.on_disconnect((pattern, signals.play("play")))


def _spoof_button(value: int) -> Writes:
    return wire.spoof(boards.SWITCH, 1, bytes((0, counts("a button's state", value, 0, 0xFF))))


def _read_temperature(channel: int) -> Writes:
    return bytes((boards.TEMPERATURE, 0x81, _channel(channel)))


def _channel(number: int) -> int:
    return counts("a channel of temperature", number, 0, 0xFF)


def _timed_temperature(board: Board, period_ms: int, repeat: int, channel: int) -> Writes:
    """Let a timer read the temperature silently."""
    return (
        programs.timer(period_ms, repeat),
        *programs.on_timer(0, bytes((boards.TEMPERATURE, 0xC1, _channel(channel)))),
    )


PLAIN: Final[Mapping[str, Callable[[Board], Writes]]] = _plain()
_FOREVER: Final = {"delay_ms": 0, "repeat": signals.FOREVER}
RULES: Final = (
    Rule("acc.config.{rate_hz}Hz.{range_g}g", wire.configure_acc),
    Rule("gyro.config.{rate_hz}Hz.{range_dps}dps", wire.configure_gyro),
    Rule("gyro.offsets.{x}_{y}_{z}", _of(wire.gyro_offsets)),
    Rule("mag.config.{xy}_{z}.{rate_hz}Hz", wire.configure_mag),
    Rule("mag.preset.{preset}", wire.preset_mag),
    Rule("fusion.config.{mode}.{range_g}g.{range_dps}dps", wire.configure_fusion),
    Rule("fusion.startstop.{mode}.{outputs}", _of(fusion_start_stop)),
    Rule("fusion.start.{mode}.{outputs}", _of(wire.start_fusion)),
    Rule("fusion.stop.{mode}", _of(wire.stop_fusion)),
    Rule("fusion.calibration_data.write.{mode}", _of(wire.write_calibration), CALIBRATION),
    Rule("led.pattern.{preset}.{colour}", signals.led_preset, _FOREVER),
    Rule("haptic.motor.{percent}pct.{duration_ms}ms", _of(signals.motor)),
    Rule("haptic.buzzer.{duration_ms}ms", _of(signals.buzzer)),
    Rule("settings.name.{name}", _of(settings.device_name)),
    Rule("settings.ad_interval.{interval_ms}ms.{timeout_s}s", settings.advertising_interval),
    Rule("settings.ad_interval.{interval_ms}ms.{timeout_s}s.type{kind}", settings.advertising_interval),
    Rule("settings.conn_params.{min_ms}_{max_ms}_{latency}_{timeout_ms}", _of(settings.connection_parameters)),
    Rule("settings.tx_power.{dbm}", _of(settings.transmit_power)),
    Rule("settings.tx_power.{dbm}dBm", _of(settings.transmit_power)),
    Rule("debug.spoof_button.{value}", _of(_spoof_button)),
    Rule("disconnect_event.buzz_{seconds}s", _of(_buzz)),
    Rule("disconnect_event.{colour}_{preset}", _flash, {"repeat": 10}),
    Rule("processor.accounter_time_on_{stream}", partial(_account, count=False)),
    Rule("processor.accounter_count_on_{stream}", partial(_account, count=True)),
    Rule("processor.{stream}_rate_limit_{period_ms}ms", _limit),
    Rule("processor.subscribe", _of(programs.subscribe_processor), {"number": 0}),
    Rule("processor.unsubscribe", _of(programs.unsubscribe_processor), {"number": 0}),
    Rule("log.{stream}", _log),
    Rule("logging.download.{entries}", _of(programs.download), {"step": 20}),
    Rule("temperature.read", _of(_read_temperature), {"channel": 0}),
    Rule("timer_then_read_temperature", _timed_temperature, TIMER_EXAMPLE),
    Rule("usb.frame.{payload}", _of(usb_frame)),
    Rule("session.{mode}.{outputs}.{range_g}g.{range_dps}dps", fusion_session),
    Rule("session.raw_packed.acc{range_g}g{rate_hz}Hz+gyro{range_dps}dps{gyro_hz}Hz", raw_session(packed=True)),
    Rule("session.raw.acc{range_g}g{rate_hz}Hz+gyro{range_dps}dps{gyro_hz}Hz", raw_session(packed=False)),
    Rule("session.fused_raw_acc+gyro+time.{rate_hz}Hz", fused_session, {"range_g": 8, "range_dps": 2000}),
)
