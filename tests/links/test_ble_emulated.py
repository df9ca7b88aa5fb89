"""bleak's own client over the emulated air."""

import asyncio
from itertools import pairwise

import pytest

from armspan.errors import DeviceLost, DeviceNotFound
from armspan.links.ble import connected, scan
from armspan.links.ble_emulated import advertisement, emulated_radio
from armspan.links.waves import LinkFaults
from fast_time import now, run
from links.worn import INFORMATION, MODEL, NOTIFY, SERVICE, WRITE, Echo

ONE, TWO = "E8:C9:8F:52:7B:07", "E8:C9:8F:52:7B:08"


def never():
    raise AssertionError("the link broke")


async def listened(client):
    """What arrives: (time, bytes)."""
    got = []
    await client.start_notify(NOTIFY, lambda _, data: got.append((now(), bytes(data))))
    return got


def numbers(got):
    return [int.from_bytes(data[:4], "little") for _, data in got]


def test_an_advertisement_is_that_of_the_trace():
    told = advertisement("MetaWear", (SERVICE,))
    assert told.hex() == "020106" + "1106" + "5ae7bafb4c46ddd99591cb8500906a32" + "0909" + "4d65746157656172"
    assert len(told) == 31


def test_a_name_that_does_not_fit_is_cut():
    told = advertisement("toio Core Cube", (SERVICE,))
    assert len(told) == 31
    assert told[-10:] == b"\x09\x08toio Cor"


def test_scan_hears_everybody_who_advertises():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(ONE))
            await air.add(Echo(TWO, name="left"))
            heard = await scan(1.0, air.radio)
            assert {(each.address, each.name) for each in heard} == {(ONE, "MetaWear"), (TWO, "left")}
            assert all(each.services == {SERVICE} and each.rssi == -50 for each in heard)

    run(scene)


def test_a_long_name_is_heard_whole():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(ONE, name="toio Core Cube-C7f"))
            assert [each.name for each in await scan(1.0, air.radio)] == ["toio Core Cube-C7f"]

    run(scene)


def test_a_client_reads_writes_and_is_notified():
    async def scene():
        async with emulated_radio() as air:
            echo = Echo(ONE)
            await air.add(echo)
            async with connected(ONE, air.radio, gone=never) as client:
                assert client.mtu_size == 23
                assert [service.uuid for service in client.services] == [SERVICE, INFORMATION]
                found = client.services.get_characteristic(WRITE)
                assert (found.handle, set(found.properties)) == (3, {"read", "write-without-response", "write"})
                got = await listened(client)
                await client.write_gatt_char(WRITE, b"abc", response=False)
                await client.write_gatt_char(WRITE, b"abcd", response=True)
                assert await client.read_gatt_char(MODEL) == b"5"
                assert await client.read_gatt_char(WRITE) == b"326a9001"
                await asyncio.sleep(0.05)
                assert [data for _, data in got] == [b"cba", b"dcba"]
                await client.stop_notify(NOTIFY)
                await client.write_gatt_char(WRITE, b"xyz", response=True)
                await asyncio.sleep(0.05)
                assert len(got) == 2
            assert echo.log == ["up", b"abc", b"abcd", b"xyz", "down"]

    run(scene)


def test_a_packet_that_does_not_fit_is_refused():
    from bleak import BleakError

    async def scene():
        async with emulated_radio() as air:
            echo = Echo(ONE)
            await air.add(echo)
            async with connected(ONE, air.radio, gone=never) as client:
                await client.write_gatt_char(WRITE, bytes(20), response=False)
                with pytest.raises(BleakError, match="21 bytes do not fit"):
                    await client.write_gatt_char(WRITE, bytes(21), response=False)
                await asyncio.sleep(0.05)
            assert echo.log == ["up", bytes(20), "down"]

    run(scene)


def test_who_is_connected_does_not_advertise_and_takes_nobody_else():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(ONE))
            async with connected(ONE, air.radio, gone=never):
                assert await scan(1.0, air.radio) == []
                with pytest.raises(DeviceNotFound, match=r"heard instead: nobody"):
                    async with connected(ONE, air.radio, gone=never, seconds=1.0):
                        pass
            assert [each.address for each in await scan(1.0, air.radio)] == [ONE]

    run(scene)


def test_three_bands_at_once_lose_nothing():
    async def scene():
        async with emulated_radio() as air:
            echoes = [Echo(f"E8:C9:8F:52:7B:0{i}", rate_hz=100.0) for i in range(3)]
            for echo in echoes:
                await air.add(echo)

            async def stay(address):
                async with connected(address, air.radio, gone=never) as client:
                    got = await listened(client)
                    await asyncio.sleep(3.0)
                    return numbers(got)

            for each, echo in zip(await asyncio.gather(*(stay(echo.address) for echo in echoes)), echoes, strict=True):
                assert len(each) >= 298
                assert each == list(range(len(echo.sent)))[: len(each)]

    run(scene)


def test_a_board_that_disconnects_is_noticed_and_found_again():
    async def scene():
        gone = []
        async with emulated_radio() as air:
            echo = Echo(ONE)
            await air.add(echo)
            async with connected(ONE, air.radio, gone=lambda: gone.append(now())) as client:
                await client.write_gatt_char(WRITE, b"bye", response=False)
                await asyncio.sleep(0.1)
                assert len(gone) == 1
                assert not client.is_connected
            async with connected(ONE, air.radio, gone=never) as client:
                assert now() - gone[0] > 0.5  # it was quiet for so long
                assert client.is_connected
            assert len(gone) == 1
            assert echo.log == ["up", b"bye", "down", "up", "down"]

    run(scene)


def test_a_broken_link_is_noticed_by_both_after_the_time_out():
    async def scene():
        gone = []
        async with emulated_radio() as air:
            echo = Echo(ONE, rate_hz=100.0)
            await air.add(echo, LinkFaults(supervision_s=0.42, away_s=1.5))
            got, cut = [], now() + 5.0

            async def stay():
                nonlocal got, cut
                async with connected(ONE, air.radio, gone=lambda: gone.append(now())) as client:
                    got = await listened(client)
                    await asyncio.sleep(0.5)
                    cut = now()
                    air.cut(ONE)
                    assert echo.there
                    await client.read_gatt_char(MODEL)  # never answered

            with pytest.raises(DeviceLost, match="broke"):
                await stay()
            assert gone[0] - cut == pytest.approx(0.42, abs=0.02)
            assert not echo.there
            assert got[-1][0] <= cut + 0.011
            assert [each.address for each in await scan(0.9, air.radio)] == []
            async with connected(ONE, air.radio, gone=never):
                assert now() - cut > 1.5
            assert air.losses(ONE).breaks == 1

    run(scene)


def test_nobody_is_kept_waiting_by_one_who_is_not_there():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(TWO))

            async def search():
                with pytest.raises(DeviceNotFound, match=f"{ONE} was not heard within 9 s; heard instead: {TWO}"):
                    async with connected(ONE, air.radio, gone=never, seconds=9.0):
                        pass

            searching = asyncio.create_task(search())
            await asyncio.sleep(0.1)
            start = now()
            async with connected(TWO, air.radio, gone=never):
                assert now() - start < 3.0
            await searching

    run(scene)


def test_giving_up_an_attempt_leaves_the_radio_usable():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(ONE))

            async def attempt():
                async with connected(ONE, air.radio, gone=never):
                    await asyncio.sleep(100.0)

            for seconds in (0.05, 0.3, 0.6, 0.9):
                task = asyncio.create_task(attempt())
                await asyncio.sleep(seconds)
                task.cancel()
                await asyncio.gather(task, return_exceptions=True)
                assert task.cancelled()
            async with connected(ONE, air.radio, gone=never) as client:
                assert client.is_connected

    run(scene)


def test_what_a_peripheral_raises_comes_out():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(ONE))
            async with connected(ONE, air.radio, gone=never) as client:
                await client.write_gatt_char(WRITE, b"fault", response=False)
                await asyncio.sleep(0.05)

    with pytest.raises(RuntimeError, match="a mistake in a peripheral"):
        run(scene)


def test_nothing_is_left_when_the_air_is_closed():
    async def scene():
        before = asyncio.all_tasks()
        async with emulated_radio() as air:
            await air.add(Echo(ONE, rate_hz=50.0), LinkFaults(breaks_per_minute=30.0, burst_s=0.03))
            async with connected(ONE, air.radio, gone=lambda: None) as client:
                await listened(client)
                await asyncio.sleep(0.2)
        await asyncio.sleep(0)
        assert asyncio.all_tasks() == before

    run(scene)


def test_who_is_taken_away_breaks_its_link_and_leaves_nothing():
    async def scene():
        gone = []
        async with emulated_radio() as air:
            before = asyncio.all_tasks()
            echo = Echo(ONE, rate_hz=50.0)
            await air.add(echo)
            async with connected(ONE, air.radio, gone=lambda: gone.append(True)) as client:
                await listened(client)
                await air.remove(ONE)
                await asyncio.sleep(0.1)
                assert gone == [True]
            sent = len(echo.sent)
            assert await scan(1.0, air.radio) == []
            assert len(echo.sent) == sent
            assert asyncio.all_tasks() == before

    run(scene)


def test_a_break_while_nobody_is_connected_only_hides_it():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(ONE), LinkFaults(supervision_s=6.0, away_s=1.0))
            air.cut(ONE)
            assert await scan(0.9, air.radio) == []
            assert [each.address for each in await scan(0.9, air.radio)] == [ONE]

    run(scene)


# --- faults ----------------------------------------------------------------------------------------------


def heard_with(faults, seconds=10.0, rate_hz=100.0):
    """(sent, got) of a stream over such a link."""
    result = []

    async def scene():
        async with emulated_radio() as air:
            echo = Echo(ONE, rate_hz=rate_hz)
            await air.add(echo, faults)
            async with connected(ONE, air.radio, gone=lambda: None) as client:
                got = await listened(client)
                await asyncio.sleep(seconds)
                result.extend([list(echo.sent), list(got)])

    run(scene, 60.0)
    return result


def test_a_share_of_the_notifications_is_lost_one_by_one():
    sent, got = heard_with(LinkFaults(loss=0.1), 8.0, rate_hz=250.0)
    assert 0.07 < 1.0 - len(got) / len(sent) < 0.13  # 2000 draws: 3 sigma are 0.02
    steps = [b - a for a, b in pairwise(numbers(got))]
    assert min(steps) == 1
    mean_run = sum(step - 1 for step in steps) / sum(step > 1 for step in steps)
    assert mean_run < 1.3  # 1 / (1 - 0.1) where each is lost by itself


def test_a_share_of_the_notifications_is_lost_in_runs():
    sent, got = heard_with(LinkFaults(loss=0.1, run=5.0), 10.0, rate_hz=400.0)
    assert 0.05 < 1.0 - len(got) / len(sent) < 0.16
    steps = [b - a for a, b in pairwise(numbers(got))]
    assert 3.5 < sum(step - 1 for step in steps) / sum(step > 1 for step in steps) < 6.5


def test_commands_are_lost_but_requests_are_not():
    async def scene():
        async with emulated_radio() as air:
            echo = Echo(ONE)
            await air.add(echo, LinkFaults(write_loss=0.5))
            async with connected(ONE, air.radio, gone=never) as client:
                for _ in range(200):
                    await client.write_gatt_char(WRITE, b"mute", response=False)
                await asyncio.sleep(0.1)
                arrived = echo.log.count(b"mute")
                assert 70 < arrived < 130  # 200 draws: 3 sigma are 21
                assert air.losses(ONE).commands == 200 - arrived
                for _ in range(20):
                    await client.write_gatt_char(WRITE, b"ask", response=True)
                assert echo.log.count(b"ask") == 20

    run(scene)


def test_packets_come_in_bursts_at_connection_events():
    sent, got = heard_with(LinkFaults(burst_s=0.04), 5.0)
    times = [t for t, _ in got]
    events = sorted({round(t, 6) for t in times})
    gaps = {round(b - a, 6) for a, b in pairwise(events)}
    assert gaps == {0.04}
    assert numbers(got) == list(range(len(got)))
    delays = [t - sent[number] for (t, _), number in zip(got, numbers(got), strict=True)]
    assert max(delays) < 0.041
    assert max(delays) - min(delays) > 0.025


def test_a_stream_above_the_ceiling_overflows():
    """Six packets per event of 50 ms are 120 a second; of 300 a second the rest is lost."""
    sent, got = heard_with(LinkFaults(burst_s=0.05, per_event=6), 5.0, rate_hz=300.0)
    assert len(sent) > 1400
    assert 110.0 < len(got) / 5.0 < 130.0


def test_a_granted_interval_thins_the_bursts():
    async def scene():
        async with emulated_radio() as air:
            echo = Echo(ONE, rate_hz=100.0)
            await air.add(echo, LinkFaults(burst_s=0.05))
            async with connected(ONE, air.radio, gone=never) as client:
                got = await listened(client)
                echo.handle.ask(0.0075, 6.0)
                await asyncio.sleep(0.1)
                got.clear()
                await asyncio.sleep(1.0)
                delays = [t - echo.sent[number] for (t, _), number in zip(got, numbers(got), strict=True)]
                assert max(delays) < 0.0085

    run(scene)


def test_latency_delays_everything_both_ways():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(ONE), LinkFaults(latency_s=0.02))
            async with connected(ONE, air.radio, gone=never) as client:
                got = await listened(client)
                start = now()
                await client.write_gatt_char(WRITE, b"abc", response=False)
                await asyncio.sleep(0.2)
                assert got[0][0] - start == pytest.approx(0.04, abs=0.002)

    run(scene)


def test_silence_and_breaks_come_at_their_times():
    async def scene():
        gone = []
        async with emulated_radio() as air:
            start = now()
            await air.add(Echo(ONE, rate_hz=100.0), LinkFaults(silent=((3.0, 4.0),), breaks_at=(5.0,)))
            async with connected(ONE, air.radio, gone=lambda: gone.append(now() - start)) as client:
                got = await listened(client)
                await asyncio.sleep(6.0)
            times = [t - start for t, _ in got]
            assert not [t for t in times if 3.001 < t < 3.999]
            assert [t for t in times if 2.9 < t < 3.0]
            assert [t for t in times if 4.0 < t < 4.1]
            assert max(times) < 5.02
            assert gone == [pytest.approx(5.42, abs=0.01)]

    run(scene)


def test_breaks_come_as_often_as_told():
    async def scene():
        async with emulated_radio() as air:
            await air.add(Echo(ONE), LinkFaults(breaks_per_minute=600.0, away_s=0.1))
            await asyncio.sleep(6.0)
            assert 40 < air.losses(ONE).breaks < 80  # Poisson, 60 +- 7.7

    run(scene)
