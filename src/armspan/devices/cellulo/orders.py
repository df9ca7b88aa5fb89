"""How an emulated Cellulo obeys its commands. What a real one cannot do with a number, this one leaves."""

import math
from typing import TYPE_CHECKING

from armspan.devices.cellulo.quantities import MM_PER_COUNT, Value
from armspan.devices.cellulo.wire import EVENTS, Packet
from armspan.simulation.bezier import Follower
from armspan.simulation.lights import TICKS_PER_SECOND, Effect

if TYPE_CHECKING:
    from armspan.devices.cellulo.firmware import Firmware


def obey(firmware: "Firmware", robot: int, packet: Packet, at: float) -> None:
    """Let a robot do what it was told at ``at`` [s]."""
    for kind in (_answer, _set, _show, _shake, _curve, _move):
        if kind(firmware, robot, packet, at):
            return


def _answer(firmware: "Firmware", robot: int, packet: Packet, at: float) -> bool:
    unit = firmware.units[robot]
    match packet.name:
        case "ping":
            firmware.say(at, robot, EVENTS.encode("acknowledged"))
        case "queryBatteryState":
            firmware.say(at, robot, EVENTS.encode("batteryStateChanged", state=unit.battery))
        case "requestFrame":
            unit.wanted_picture = True
        case "reset":
            firmware.boot(robot, at)
        case "shutdown":
            firmware.sleep(robot, at)
        case _:
            return False
    return True


def _set(firmware: "Firmware", robot: int, packet: Packet, at: float) -> bool:
    unit, (value, *_) = firmware.units[robot], (*_whole(packet), 0)
    match packet.name:
        case "setPoseBcastPeriod":
            firmware.localisation.period[robot] = value
        case "setTimestampingEnabled":
            firmware.localisation.stamped[robot] = bool(value)
        case "setExposureTime":
            unit.exposure = value
        case "setLEDResponseMode":
            unit.response = value
        case "setLocomotionInteractivityMode":
            firmware.motion.block(robot, bool(value))
        case "setGestureEnabled":
            unit.feels = bool(value)
            if not unit.feels:
                firmware.tell_hold(robot, at)
        case _:
            return False
    return True


def _show(firmware: "Firmware", robot: int, packet: Packet, at: float) -> bool:
    if packet.name != "setVisualEffect":
        return False
    effect, red, green, blue, value = _whole(packet)
    unit = firmware.units[robot]
    if not unit.fading:
        unit.show(math.floor(at * TICKS_PER_SECOND + 1e-9), Effect(effect), (red, green, blue), value)
    return True


def _shake(firmware: "Firmware", robot: int, packet: Packet, at: float) -> bool:
    numbers, motion = _numbers(packet), firmware.motion
    match packet.name:
        case "simpleVibrate":
            motion.shake.start(1000 * at, robot, numbers[:3], numbers[3], numbers[4])
        case "vibrateOnMotion":
            motion.backdrive.ripple(1000 * at, robot, numbers[0], numbers[1])
        case "clearHapticFeedback":
            motion.shake.stop(robot)
            motion.backdrive.still(robot)
        case "setCasualBackdriveAssistEnabled":
            motion.backdrive.ease(robot, bool(numbers[0]))
        case "setHapticBackdriveAssist":
            motion.backdrive.help(robot, numbers)
        case _:
            return False
    return True


def _curve(firmware: "Firmware", robot: int, packet: Packet, at: float) -> bool:
    numbers, chain = _numbers(packet), firmware.units[robot].chain
    if "oly" in packet.name and not all(map(math.isfinite, numbers)):
        return True
    match packet.name:
        case "polyBezierInit":
            chain.begin((numbers[0], numbers[1]))
        case "polyBezierAppend":
            chain.append((numbers[0], numbers[1]), (numbers[2], numbers[3]), (numbers[4], numbers[5]))
        case "setGoalPolyBezier":
            firmware.motion.track_curve(robot, Follower(chain, numbers[0], numbers[1]))
        case "setGoalPolyBezierAligned":
            firmware.motion.track_curve(robot, Follower(chain, numbers[0], numbers[2], numbers[1]))
        case _:
            return False
    return True


def _move(firmware: "Firmware", robot: int, packet: Packet, at: float) -> bool:
    motion, args, unit = firmware.motion, packet.args, firmware.units[robot]
    match packet.name:
        case "clearTracking":
            motion.clear(robot)
        case "setGoalVelocity":
            motion.track_velocity(robot, _numbers(packet))
        case "setMotorOutput" | "setAllMotorOutputs":
            whole = _whole(packet)
            outputs = {whole[0] - 1: whole[1]} if packet.name == "setMotorOutput" else dict(enumerate(whole))
            if not firmware.localisation.kidnapped[robot]:
                unit.wheels, unit.wheels_since = motion.turn_wheels(robot, outputs), at
        case _:
            x, y = (round(_number(args[key]) / MM_PER_COUNT) if key in args else None for key in ("x_mm", "y_mm"))
            theta = 100 * _number(args["theta_deg"]) if "theta_deg" in args else None
            vmax, wmax = (_number(args.get(key, 0.0)) for key in ("v_max_mm_s", "w_max_rad_s"))
            motion.track_pose(robot, x, y, theta, vmax=vmax, wmax=wmax)
    return True


def _number(value: Value) -> float:
    return float(value) if isinstance(value, int | float) else 0.0


def _numbers(packet: Packet) -> list[float]:
    """A command's numbers in their units, in order."""
    return [_number(value) for value in packet.args.values()]


def _whole(packet: Packet) -> list[int]:
    """A command's whole numbers as they travelled."""
    return [number for number in packet.raw if isinstance(number, int)]
