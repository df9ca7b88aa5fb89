"""Bluetooth sockets where there are none: the errors of a real one, and a Unix socket in its place."""

import asyncio
import errno
import os
import socket

import pytest

from armspan.errors import DeviceError, DeviceNotFound
from armspan.links import rfcomm
from fast_time import run

MAC, ADAPTER = "00:06:66:E7:8A:D8", "00:1A:7D:DA:71:13"


class Fake(socket.socket):
    """One end of a pair that connects to an address as a Bluetooth socket does, or fails."""

    def __init__(self, error=None, slow=False):
        ours, self.other = socket.socketpair()
        super().__init__(fileno=ours.detach())
        self.error, self.slow, self.done = error, slow, []

    def bind(self, address):
        self.done.append(("bind", address))

    def connect(self, address):
        self.done.append(("connect", address))
        if self.error is not None:
            raise OSError(self.error, os.strerror(self.error))


def test_bytes_go_both_ways_over_a_connected_socket(monkeypatch):
    fake = Fake()
    monkeypatch.setattr(rfcomm, "open_socket", lambda: fake)

    async def scene():
        line = await rfcomm.connected(MAC, ADAPTER)
        assert fake.done == [("bind", (ADAPTER, 0)), ("connect", (MAC, 1))]
        fake.other.sendall(b"\x01A")
        assert await line.read() == b"\x01A"
        line.write(b"\x01P")
        assert fake.other.recv(9) == b"\x01P"
        waiting = asyncio.ensure_future(line.read())
        await asyncio.sleep(0.01)
        fake.other.close()
        assert await waiting == b""
        line.close()
        line.close()
        assert fake.fileno() == -1

    run(scene)


def test_any_adapter_needs_no_binding(monkeypatch):
    fake = Fake()
    monkeypatch.setattr(rfcomm, "open_socket", lambda: fake)

    async def scene():
        (await rfcomm.connected(MAC)).close()
        assert fake.done == [("connect", (MAC, 1))]
        fake.other.close()

    run(scene)


@pytest.mark.parametrize(
    ("number", "kind", "words"),
    [
        (errno.EHOSTDOWN, DeviceNotFound, f"{MAC} does not answer over Bluetooth (Host is down); see that it is on"),
        (errno.ECONNREFUSED, DeviceNotFound, "no other host holds it"),
        (errno.ETIMEDOUT, DeviceNotFound, "charged and near"),
        (errno.EHOSTUNREACH, DeviceError, f"the Bluetooth adapter {ADAPTER} is not there or is off"),
        (errno.ENODEV, DeviceError, "bluetoothctl power on"),
        (errno.EACCES, DeviceError, "has no permission"),
        (errno.EPROTONOSUPPORT, DeviceError, "sudo modprobe rfcomm"),
    ],
)
def test_what_went_wrong_and_what_to_do(monkeypatch, number, kind, words):
    fake = Fake(number)
    monkeypatch.setattr(rfcomm, "open_socket", lambda: fake)

    async def scene():
        with pytest.raises(DeviceError) as told:
            await rfcomm.connected(MAC, ADAPTER)
        assert type(told.value) is kind
        assert words in str(told.value)
        assert fake.fileno() == -1
        fake.other.close()

    run(scene)


def test_no_answer_at_all(monkeypatch):
    fake = Fake()
    monkeypatch.setattr(rfcomm, "open_socket", lambda: fake)

    async def scene():
        async def never(*_):
            await asyncio.sleep(99)

        monkeypatch.setattr(asyncio.get_running_loop(), "sock_connect", never, raising=False)
        with pytest.raises(DeviceNotFound, match=r"does not answer over Bluetooth \(no answer\)"):
            await rfcomm.connected(MAC, seconds=0.5)
        assert fake.fileno() == -1
        fake.other.close()

    run(scene)


def test_a_python_without_such_sockets_is_told_of_others(monkeypatch):
    monkeypatch.delattr(socket, "AF_BLUETOOTH", raising=False)
    assert not rfcomm.available()
    with pytest.raises(DeviceError, match=r"AF_BLUETOOTH is missing.*/usr/bin/python3 .*/dev/rfcommN .*TCP relay"):
        rfcomm.open_socket()


def test_a_system_without_bluetooth(monkeypatch):
    monkeypatch.setattr(socket, "AF_BLUETOOTH", 77, raising=False)  # a family that no system has
    monkeypatch.setattr(socket, "BTPROTO_RFCOMM", 3, raising=False)
    with pytest.raises(DeviceError, match="the system has no Bluetooth: load its modules"):
        rfcomm.open_socket()
