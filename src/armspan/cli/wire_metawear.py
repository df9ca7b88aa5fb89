"""The MetaWear part of ``armspan wire``: lines as {"id", "board"} and {"notification", "board"}."""

import re
from collections.abc import Mapping
from typing import Any

from armspan.cli.wire_lines import hexadecimal, mapping, required, text_of
from armspan.devices.metawear import names as by_name
from armspan.devices.metawear.boards import NAMED, board_named
from armspan.devices.metawear.notifications import Ranges
from armspan.devices.metawear.reports import report
from armspan.devices.metawear.usb_frames import START, UsbFramer, usb_frame
from armspan.devices.metawear.wire import decode as meaning_of
from armspan.devices.metawear.write_names import name_of_write
from armspan.errors import DeviceError

_DEFAULT = "mmrl_current"
_BESIDE = {"delay": "delay_ms", "repeat": "repeat"}
_NUMBER = r"(\d+(?:\.\d+)?)"


def names() -> list[str]:
    """The forms of all names, and the boards."""
    return [*by_name.forms(), f"board= is one of {', '.join(NAMED)}"]


def asked(line: Mapping[str, Any]) -> str:
    """What a line wants where nobody says it."""
    return "decode" if {"notification", "hex", "frame"} & set(line) and "payload" not in line else "encode"


def from_words(verb: str, word: str, args: dict[str, Any]) -> dict[str, Any]:
    """The command line as a line."""
    board = {"board": args.pop("board")} if "board" in args else {}
    return {"id": word, "args": args, **board} if verb == "encode" else {"notification": word, **args, **board}


def encode(line: Mapping[str, Any]) -> dict[str, Any]:
    """The writes of a named command, as steps too where it is a session; or a payload's USB frame."""
    if "payload" in line and "id" not in line:
        return {"payload": line["payload"], "frame": usb_frame(hexadecimal(line, "payload", "a payload")).hex()}
    name = required(line, "id" if "id" in line else "name")
    told = line.get("board")
    if told is not None and not isinstance(told, str):
        raise DeviceError(f"a line's 'board' is {str(told)[:40]}; expected one of {', '.join(NAMED)}")
    steps = by_name.encode(name, told, {**_beside(name, line.get("note")), **mapping(line, "args")})
    answer: dict[str, Any] = {"id": name} | ({"board": told} if told else {})
    answer["writes"] = [write.hex() for _, writes in steps for write in writes]
    if len(steps) > 1:
        answer["steps"] = [{"step": title, "writes": [write.hex() for write in writes]} for title, writes in steps]
    return answer


def decode(line: Mapping[str, Any]) -> dict[str, Any]:
    """What a notification means; bytes from a USB cable are taken out of their frames."""
    key = next((key for key in ("notification", "hex", "frame") if key in line), "notification")
    data = hexadecimal(line, key, "a notification")
    same = {key: line[key] for key in ("id", "board") if key in line}
    if data[:1] != bytes((START,)):
        return same | _said(data, _board(line), _ranges(line))
    payloads = UsbFramer().feed(data)
    if not payloads:
        raise DeviceError(f"{data[:20].hex()} holds no whole USB frame: 1f, length, payload, 0a")
    said = [_said(payload, _board(line), _ranges(line)) for payload in payloads]
    return same | {"frame": data.hex()} | (said[0] if len(said) == 1 else {"notifications": said})


def _said(data: bytes, board: str, ranges: Ranges) -> dict[str, Any]:
    """What the board says with some bytes, or else what a host says with them."""
    try:
        return {"notification": data.hex(), **report(meaning_of(data, board_named(board), ranges))}
    except DeviceError:
        name = name_of_write(data, board)
        if name is None:
            raise
        return {"write": data.hex(), "kind": "write", "decoded": name}


def told(answer: Mapping[str, Any]) -> list[str]:
    """An answer for a person."""
    if "writes" in answer:
        return list(answer["writes"])
    if "notifications" in answer:
        return [line for one in answer["notifications"] for line in told(one)]
    if "kind" not in answer:
        return [answer["frame"]]
    if "write" in answer:
        return [f"written by the host: {answer['decoded']}"]
    units = f" [{answer['units']}]" if "units" in answer else ""
    return [f"{answer.get('of', answer['kind'])}{units}: {_in_words(answer['decoded'])}"]


def _in_words(value: Any) -> str:
    if isinstance(value, dict):
        parts = (
            (key, f"({_in_words(part)})" if isinstance(part, dict) else _in_words(part)) for key, part in value.items()
        )
        return " ".join(f"{key}={part}" for key, part in parts)
    return "; ".join(map(_in_words, value)) if isinstance(value, list) else text_of(value)


def _board(line: Mapping[str, Any]) -> str:
    name = line.get("board")
    if name is None:
        chips = {"bmi270": "mms"}
        name = next((board for chip, board in chips.items() if chip in str(line.get("id"))), _DEFAULT)
    if not isinstance(name, str):
        raise DeviceError(f"a line's 'board' is {str(name)[:40]}; expected one of {', '.join(NAMED)}")
    return name


def _ranges(line: Mapping[str, Any]) -> Ranges:
    """The chips' ranges where a line tells them: as range_g and range_dps, at the end of its id, in a precondition."""
    words = f"{line.get('id', '')} {line.get('precondition', '')} {line.get('range', '')}"
    units = {"g": r"g\b", "dps": r"(?:dps\b|deg/s)"}
    found = {unit: re.search(rf"{_NUMBER} ?{form}", words) for unit, form in units.items()}
    said = {unit: float(match[1]) if match else None for unit, match in found.items()}
    return Ranges(
        acc_g=_number(line, "range_g", said["g"] or 2),
        gyro_dps=_number(line, "range_dps", said["dps"] or 2000),
        processors=_processors(line),
    )


def _processors(line: Mapping[str, Any]) -> dict[int, Any]:
    """What the data processors' output is, where a line or its id tells."""
    kinds = ("fused", "quaternion", "acc", "gyro", "mag", "raw")
    what = line.get("processor", "acc" if "accounter" in str(line.get("id")) else None)
    if what is not None and what not in kinds:
        raise DeviceError(f"processor is {what!r}; expected what its output is: {', '.join(kinds)}")
    return {} if what is None else dict.fromkeys(range(256), what)


def _number(line: Mapping[str, Any], key: str, otherwise: float) -> float:
    value = line.get(key, otherwise)
    if not isinstance(value, int | float):
        raise DeviceError(f"{key} is {value!r}; expected a number")
    return value


def _beside(name: str, note: Any) -> dict[str, str]:
    """Arguments that a LED's name has no room for, and its note tells: delay=5000 ms, repeat=10."""
    if not name.startswith("led.pattern") or not isinstance(note, str):
        return {}
    return {_BESIDE[key]: value for key, value in re.findall(r"\b(delay|repeat)=(\d+)", note)}
