"""An emulated air in HCI packets over loopback TCP: two parties that share nothing but a socket."""

import asyncio
from contextlib import asynccontextmanager

import pytest

from armspan.errors import ConfigError, DeviceError, DeviceLost, DeviceNotFound
from armspan.links.ble import OWN, Radio, connected, scan
from armspan.links.ble_emulated import emulated_radio
from armspan.links.hci import hci_radio, radio_named
from armspan.links.hci_air import serve_air
from armspan.links.waves import LinkFaults
from fast_time import now, run
from links.worn import MODEL, NOTIFY, SERVICE, WRITE, Echo

ONE, TWO = "E8:C9:8F:52:7B:07", "E8:C9:8F:52:7B:08"


def never():
    raise AssertionError("the link broke")


@asynccontextmanager
async def apart(*echoes, faults=None):
    """The air, and the radio of somebody who knows only the port."""
    async with emulated_radio() as air:
        for echo in echoes:
            await air.add(echo, faults)
        async with serve_air(air, 0) as port:
            yield air, radio_named(f"bumble:tcp-client:127.0.0.1:{port}")


async def listened(client):
    got = []
    await client.start_notify(NOTIFY, lambda _, data: got.append((now(), bytes(data))))
    return got


async def until(what, seconds=20.0):
    async with asyncio.timeout(seconds):
        while not what():
            await asyncio.sleep(0.02)


# --- what is asked of any radio --------------------------------------------------------------------------


def test_scan_hears_names_and_services():
    async def scene():
        async with apart(Echo(ONE), Echo(TWO, name="toio Core Cube-C7f")) as (_, radio):
            heard = await scan(1.0, radio)
            assert {(each.address, each.name) for each in heard} == {(ONE, "MetaWear"), (TWO, "toio Core Cube-C7f")}
            assert all(each.services == {SERVICE} and each.rssi == -50 for each in heard)

    run(scene)


def test_a_client_reads_writes_and_is_notified():
    async def scene():
        echo = Echo(ONE)
        async with apart(echo) as (_, radio):
            async with connected(ONE, radio, gone=never) as client:
                got = await listened(client)
                await client.write_gatt_char(WRITE, b"abc", response=False)
                await client.write_gatt_char(WRITE, b"abcd", response=True)
                assert await client.read_gatt_char(MODEL) == b"5"
                await until(lambda: len(got) == 2)
                assert [data for _, data in got] == [b"cba", b"dcba"]
            await until(lambda: "down" in echo.log)
            assert echo.log == ["up", b"abc", b"abcd", "down"]

    run(scene)


def test_two_connections_share_one_controller():
    async def scene():
        one, two = Echo(ONE, rate_hz=100.0), Echo(TWO, rate_hz=100.0)
        async with (
            apart(one, two) as (_, radio),
            connected(ONE, radio, gone=never) as first,
            connected(TWO, radio, gone=never) as second,
        ):
            heard = [await listened(client) for client in (first, second)]
            await until(lambda: all(len(got) >= 100 for got in heard))
            for got, echo in zip(heard, (one, two), strict=True):
                numbers = [int.from_bytes(data[:4], "little") for _, data in got]
                assert numbers == list(range(len(numbers)))
                assert len(echo.sent) - len(numbers) <= 3
                assert got[99][0] - got[0][0] == pytest.approx(0.99, abs=0.05)

    run(scene)


def test_what_is_not_there_is_not_found_and_the_attempt_leaves_nothing():
    async def scene():
        async with apart(Echo(ONE)) as (_, radio):
            with pytest.raises(DeviceNotFound, match=rf"heard instead: {ONE} \(MetaWear\)"):
                async with connected(TWO, radio, gone=never, seconds=1.0):
                    pass
            async with connected(ONE, radio, gone=never):
                pass

    run(scene)


def test_an_attempt_that_is_given_up_is_taken_back():
    async def scene():
        echo = Echo(ONE)
        async with apart(echo) as (air, radio):
            assert await scan(0.5, radio)
            (seen,) = await _devices(radio)
            air.worsen(ONE, LinkFaults(away_s=3.0))
            air.cut(ONE)
            client = radio.client(seen, disconnected_callback=None, timeout=1.0)
            with pytest.raises(TimeoutError):
                await client.connect(False)
            await asyncio.sleep(5.0)  # it is in reach again, and nobody wants it any more
            assert "up" not in echo.log
            async with connected(ONE, radio, gone=never) as other:
                assert await other.read_gatt_char(MODEL) == b"5"

    run(scene)


async def _devices(radio):
    import bleak

    return await bleak.BleakScanner.discover(0.5, backend=radio.scanner)


def test_a_board_that_offers_other_services_is_asked_again():
    async def scene():
        echo = Echo(ONE)
        async with apart(echo) as (_, radio):
            broke = []
            async with connected(ONE, radio, gone=lambda: broke.append(now())) as client:
                assert client.services.get_characteristic(MODEL) is not None
                table = echo.table()
                echo.services, echo.table = ("00001530-1212-efde-1523-785feabcd123",), lambda: table[:1]
                echo.handle.renew()
                await until(lambda: broke)
            async with connected(ONE, radio, gone=never) as client:
                assert client.services.get_characteristic(MODEL) is None

    run(scene)


# --- losses ----------------------------------------------------------------------------------------------


def test_a_broken_link_is_told():
    async def scene():
        broke = []
        async with apart(Echo(ONE, rate_hz=100.0), faults=LinkFaults(breaks_at=(3.0,))) as (_, radio):
            began = now()
            async with connected(ONE, radio, gone=lambda: broke.append(now() - began)) as client:
                await listened(client)
                await until(lambda: broke)
            assert broke[0] == pytest.approx(3.42, abs=0.1)
            async with connected(ONE, radio, gone=never):
                pass

    run(scene)


def test_a_client_that_vanishes_is_a_loss_of_radio():
    async def scene():
        echo = Echo(ONE)
        async with emulated_radio() as air:
            await air.add(echo)
            async with serve_air(air, 0) as port, _relayed(port) as (between, cut):
                async with connected(ONE, radio_named(f"bumble:tcp-client:127.0.0.1:{between}"), gone=lambda: None):
                    cut()
                    vanished = now()
                    await until(lambda: "down" in echo.log)
                    assert now() - vanished == pytest.approx(0.42, abs=0.1)  # not before the link times out
                async with connected(ONE, hci_radio(f"tcp-client:127.0.0.1:{port}"), gone=never) as client:
                    assert await client.read_gatt_char(MODEL) == b"5"

    run(scene)


def test_a_controller_that_goes_away_is_told_and_waited_for():
    async def scene():
        broke = []
        async with emulated_radio() as air:
            await air.add(Echo(ONE))
            async with serve_air(air, 0) as port, _relayed(port) as (between, cut):
                radio = hci_radio(f"tcp-client:127.0.0.1:{between}")

                async def talk():
                    async with connected(ONE, radio, gone=lambda: broke.append(now())) as client:
                        cut()
                        await until(lambda: broke)
                        await client.read_gatt_char(MODEL)

                with pytest.raises(DeviceLost, match="broke"):
                    await talk()
                async with connected(ONE, radio, gone=never) as client:
                    assert await client.read_gatt_char(MODEL) == b"5"
            with pytest.raises(DeviceLost, match=r"No Bluetooth controller answers at tcp-client"):
                await scan(0.1, radio)

    run(scene)


def test_a_controller_that_goes_away_ends_a_scan_and_an_attempt():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(ONE))
            async with serve_air(air, 0) as port, _relayed(port) as (between, cut):
                radio = hci_radio(f"tcp-client:127.0.0.1:{between}")
                asyncio.get_running_loop().call_later(0.5, cut)
                assert [each.address for each in await scan(1.0, radio)] == [ONE]
                (seen,) = await _devices(radio)
                air.cut(ONE, 60.0)
                asyncio.get_running_loop().call_later(0.5, cut)
                client = radio.client(seen, disconnected_callback=None, timeout=5.0)
                with pytest.raises(EOFError, match="went away"):
                    await client.connect(False)

    run(scene)


def test_an_idle_radio_lets_go():
    async def scene():
        async with apart(Echo(ONE)) as (_, radio):
            before = asyncio.all_tasks()
            await scan(0.5, radio)
            assert len(asyncio.all_tasks() - before) == 1  # the server's
            await asyncio.sleep(2.5)
            assert asyncio.all_tasks() == before
            assert await scan(1.0, radio)

    run(scene)


def test_a_loop_that_ends_closes_its_radio():
    """Warnings are errors: a socket that stays open would be one."""

    async def scene():
        async with apart(Echo(ONE)) as (_, radio):
            assert await scan(0.5, radio)

    for _ in range(2):
        run(scene)


# --- words -----------------------------------------------------------------------------------------------


def test_the_second_client_is_told_that_there_is_one():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(ONE))
            async with serve_air(air, 0) as port, _relayed(port) as (between, _):
                first, second = (hci_radio(f"tcp-client:127.0.0.1:{at}") for at in (port, between))
                async with connected(ONE, first, gone=never) as client:
                    with pytest.raises(DeviceError, match="one program at a time"):
                        await scan(0.1, second)
                    assert await client.read_gatt_char(MODEL) == b"5"

    run(scene)


@pytest.mark.parametrize(
    ("transport", "words"),
    [
        ("tcp-client:127.0.0.1:1", "start `armspan emulate metawear`"),
        ("tcp-client:nowhere", "No Bluetooth controller answers at tcp-client:nowhere"),
        ("pigeon:7", "'pigeon:7' is no transport that bumble knows; expected tcp-client:HOST:PORT"),
        ("serial:/dev/none", "No Bluetooth controller answers at serial:/dev/none"),
    ],
)
def test_where_there_is_no_controller_one_sentence_says_so(transport, words):
    async def scene():
        with pytest.raises(DeviceError) as error:
            await scan(0.1, hci_radio(transport))
        assert not isinstance(error.value, DeviceLost)
        assert words in str(error.value)
        assert "\n" not in str(error.value)

    run(scene)


def test_somebody_who_speaks_no_hci_is_not_waited_for():
    async def scene():
        async def silent(reader, writer):
            await reader.read()
            writer.close()

        async with await asyncio.start_server(silent, "127.0.0.1", 0) as server:
            port = server.sockets[0].getsockname()[1]
            with pytest.raises(DeviceError, match="no answer within 10 s"):
                await scan(0.1, hci_radio(f"tcp-client:127.0.0.1:{port}"))
            await asyncio.sleep(0.1)

    run(scene)


def test_nonsense_from_a_client_ends_only_this_client():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(ONE))
            async with serve_air(air, 0) as port:
                reader, writer = await asyncio.open_connection("127.0.0.1", port)
                writer.write(b"GET / HTTP/1.1\r\n\r\n")
                assert await reader.read() == b""
                writer.close()
                assert await scan(1.0, hci_radio(f"tcp-client:127.0.0.1:{port}"))

    run(scene)


def test_a_port_that_is_taken_is_told():
    async def scene():
        async with emulated_radio() as air, serve_air(air, 0) as port:
            with pytest.raises(DeviceError, match=rf"port {port} of 127.0.0.1 cannot be opened"):
                async with serve_air(air, port):
                    pass

    run(scene)


def test_radios_by_name():
    assert radio_named(None) is OWN
    assert radio_named("hci1") == Radio(adapter="hci1")
    assert radio_named("bumble:usb:0") is hci_radio("usb:0")
    for wrong in ("", "hci", "usb:0", "bumble:", "hci1 "):
        with pytest.raises(ConfigError, match="names no radio; expected an adapter such as 'hci1'"):
            radio_named(wrong)


@asynccontextmanager
async def _relayed(port):
    """A way to ``port`` that can be cut, as by the death of whoever is at one of its ends."""
    writers, tasks = [], []

    async def pump(reader, writer):
        try:
            while data := await reader.read(4096):
                writer.write(data)
        finally:
            writer.close()

    async def serve(reader, writer):
        theirs, ours = await asyncio.open_connection("127.0.0.1", port)
        writers.extend((writer, ours))
        tasks.append(asyncio.current_task())
        await asyncio.gather(pump(reader, ours), pump(theirs, writer), return_exceptions=True)

    def cut():
        for writer in writers:
            writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    try:
        yield server.sockets[0].getsockname()[1], cut
    finally:
        server.close()
        cut()
        await asyncio.gather(*tasks, return_exceptions=True)
