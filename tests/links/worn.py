"""A peripheral that answers what is written, backwards, and counts as often as it is told to."""

from armspan.links.ble_emulated import Characteristic, Service

SERVICE = "326a9000-85cb-9195-d9dd-464cfbbae75a"
WRITE = "326a9001-85cb-9195-d9dd-464cfbbae75a"
NOTIFY = "326a9006-85cb-9195-d9dd-464cfbbae75a"
MODEL = "00002a24-0000-1000-8000-00805f9b34fb"
INFORMATION = "0000180a-0000-1000-8000-00805f9b34fb"


class Echo:
    """``rate_hz`` numbers a second go out once somebody is there."""

    services = (SERVICE,)

    def __init__(self, address="E8:C9:8F:52:7B:07", name="MetaWear", rate_hz=0.0):
        self.address, self.name, self.rate_hz = address, name, rate_hz
        self.handle, self.log, self.sent, self.refused = None, [], [], 0
        self.there, self._next = False, None

    def table(self):
        values = (Characteristic(WRITE, ("read", "write-without-response", "write")),)
        values += (Characteristic(NOTIFY, ("read", "notify")),)
        return (Service(SERVICE, values), Service(INFORMATION, (Characteristic(MODEL, ("read",), b"5"),)))

    def attach(self, handle):
        self.handle = handle

    def read(self, uuid):
        return uuid[:8].encode()

    def written(self, uuid, data):
        self.log.append(data)
        if data == b"bye":
            self.handle.drop(0.5)
        elif data == b"fault":
            raise RuntimeError("a mistake in a peripheral")
        elif data != b"mute":
            self.handle.notify(NOTIFY, data[::-1])

    def connected(self):
        self.there, self._next = True, None
        self.log.append("up")

    def disconnected(self):
        self.there = False
        self.log.append("down")

    def advance(self, t):
        if not self.there or not self.rate_hz:
            return None
        if self._next is None:
            self._next = t + 1.0 / self.rate_hz
        while self._next <= t + 1e-9:
            number = len(self.sent)
            if self.handle.notify(NOTIFY, number.to_bytes(4, "little") + bytes(15)):
                self.sent.append(t)
            self._next += 1.0 / self.rate_hz
        return self._next
