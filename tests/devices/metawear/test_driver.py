"""The client against the emulated board, through bleak's own client and the emulated air, in fast time."""

import asyncio
import math
from contextlib import asynccontextmanager

import numpy as np
import pytest

from armspan.devices.metawear import connection
from armspan.devices.metawear.board import MetaWearBoard
from armspan.devices.metawear.board_models import MODELS, Traits
from armspan.devices.metawear.board_usb import serve_usb
from armspan.devices.metawear.driver import MetaWearBand
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.metawear.peripheral import MetaWearPeripheral
from armspan.errors import DeviceError, DeviceNotFound
from armspan.links.ble_emulated import emulated_radio
from armspan.links.waves import LinkFaults
from armspan.records import GoTo, Haptic, ImuSample, Light, Link, Stop, Tap
from devices.promises import check_closes, check_events, check_lost_and_mended, check_rest
from fast_time import now, run

RIGHT, LEFT = "E8:C9:8F:52:7B:07", "E8:C9:8F:52:7B:08"


@pytest.fixture(autouse=True)
def _faster(monkeypatch):
    """Everything is in one process and waits for nobody else."""
    monkeypatch.setattr("fast_time.FASTER", 100.0)


class Worn:
    """A band, its board and everything it told with the time when it came."""

    def __init__(self, air, board, **entry):
        self.air, self.board = air, board
        settings = {"name": "right", "address": board.address} | entry
        folder = settings.pop("calibration", None)
        self.band = MetaWearBand(MetaWearEntry(**settings), radio=air.radio, now=now, calibration=folder)
        self.told = []

    def __aiter__(self):
        return self.band.source()

    @property
    def events(self):
        return [event for _, event in self.told]

    @property
    def samples(self):
        return [event for event in self.events if isinstance(event, ImuSample)]

    @property
    def links(self):
        return [(event.up, event.fresh) for event in self.events if isinstance(event, Link)]

    @property
    def stream(self):
        (counters,) = self.band.report().streams.values()
        return counters

    async def listen(self):
        source = self.band.source()
        try:
            async for event in source:
                self.told.append((now(), event))
        finally:
            await source.aclose()

    async def until(self, what, seconds=20.0):
        async with asyncio.timeout(seconds):
            while not what():
                await asyncio.sleep(0.02)

    async def streams(self, count=50):
        wanted = len(self.samples) + count
        await self.until(lambda: len(self.samples) >= wanted)


@asynccontextmanager
async def worn(board=None, faults=None, **entry):
    async with emulated_radio(np.random.default_rng(5)) as air:
        board = board or MetaWearBoard()
        await air.add(MetaWearPeripheral(board), faults)
        band = Worn(air, board, **entry)
        listener = asyncio.create_task(band.listen())
        try:
            yield band
        finally:
            listener.cancel()
            (ended,) = await asyncio.gather(listener, return_exceptions=True)
            if not isinstance(ended, asyncio.CancelledError):
                raise ended


@pytest.fixture(params=["fusion", "raw"])
def profile(request):
    return request.param


# --- promises --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["mmrl_current", "mms_current", "mmr_fw150"])
def test_a_band_at_rest_feels_gravity_a_hundred_times_a_second(model, profile):
    async def scene():
        async with worn(MetaWearBoard(model), profile=profile) as band:
            await band.streams(20)
            began, count = now(), len(band.samples)
            await asyncio.sleep(2.0)
            assert len(band.samples) - count == pytest.approx(100 * (now() - began), abs=3)
            check_events(band.events)
            check_rest(band.samples)
            assert band.links == [(True, True)]
            assert band.events[0] == Link(band.events[0].t, "right", True, True)
            assert all((sample.quat is None) == (profile == "raw") for sample in band.samples)

    run(scene)


@pytest.mark.parametrize("model", ["mmr_fw113", "mmrl_fw113", "mms"])
def test_older_firmware_gives_orientations(model):
    async def scene():
        async with worn(MetaWearBoard(model)) as band:
            await band.streams(50)
            check_rest(band.samples)

    run(scene)


def test_closing_a_source_leaves_nothing_behind(profile):
    async def scene():
        async with emulated_radio() as air:
            board = MetaWearBoard()
            await air.add(MetaWearPeripheral(board))
            before = asyncio.all_tasks()
            source = Worn(air, board, profile=profile).band.source()
            for _ in range(30):
                await anext(source)
            await asyncio.wait_for(source.aclose(), 5.0)
            await asyncio.sleep(0.1)  # the board advertises again
            assert asyncio.all_tasks() <= before

    run(scene)


def test_closing_a_cable_leaves_nothing_behind():
    async def scene():
        async with serve_usb(MetaWearBoard("mms_current")) as path:
            await check_closes(Worn(_NoAir, MetaWearBoard("mms_current"), address=f"usb:{path}").band.source(), 30)

    run(scene)


def test_closing_one_that_was_never_heard():
    async def scene():
        async with emulated_radio() as air:
            band = Worn(air, MetaWearBoard()).band
            source = band.source()
            lost = await anext(source)
            assert isinstance(lost, Link)
            assert not lost.up
            assert "was not heard" in band.report().trouble
            await source.aclose()

    run(scene)


def test_a_lost_link_is_told_and_mended(profile):
    async def scene():
        async with worn(profile=profile) as band:
            await band.streams()
            cut = now()
            band.air.cut(RIGHT)
            await band.until(lambda: (False, False) in band.links)
            await band.until(lambda: len(band.links) == 3)
            assert now() - cut < 5.0
            await band.streams()
            check_lost_and_mended(band.events, "right")
            check_events(band.events)
            report = band.band.report()
            assert (report.connections, report.resumed, report.links_lost) == (2, 1, 1)
            (gap,) = [gap for gap in band.stream.latest_gaps if gap.seconds > 0.25]
            assert gap.samples == pytest.approx(100 * gap.seconds - 1, abs=2)
            # Nobody knows how far an arm turned without its fusion; the fusion knows.
            assert band.links == [(True, True), (False, False), (True, profile == "raw")]

    run(scene)


# --- beginning and end -----------------------------------------------------------------------------------


def test_a_board_is_cleaned_before_it_is_used():
    async def scene():
        board = MetaWearBoard()
        for write in ("09021305ffa00f05", "0a02110aff080104", "0a03f8b80b00", "030401", "030101", "03020100", "020102"):
            board.write(bytes.fromhex(write))
        async with worn(board) as band:
            await band.streams()
            assert board.processors.known == {}
            assert (3, 4) not in board.sensing.subscribed
            assert {bytes(event.target) for event in board.events.values()} == {b"\x02\x03", b"\x02\x01", b"\x08\x01"}

    run(scene)


def test_the_end_is_clean(profile):
    async def scene():
        async with worn(profile=profile) as band:
            await band.streams()
            assert band.board.up
        board = band.board
        await asyncio.sleep(0.1)
        assert not board.up
        assert board.events == {}  # else it would buzz now
        assert board.haptics == []
        assert board.processors.known == {}
        assert not board.sensing.fusion.enabled
        assert board.sensing.subscribed == set()
        assert not any(chip.powered or chip.interrupt for chip in board.sensing.chips.values())

    run(scene)


def test_a_band_that_loses_its_host_says_so_to_its_wearer():
    async def scene():
        async with worn() as band:
            await band.streams()
            band.air.cut(RIGHT, 3.0)
            await band.until(lambda: bool(band.board.haptics))
            assert band.board.haptics[0].strength == 1.0
            assert band.board.lamp.playing
            assert band.board.sensing.fusion.enabled

    run(scene)


@pytest.mark.parametrize("style", ["short", "silent"])
def test_a_module_that_is_absent_may_answer_or_not(style):
    async def scene():
        modules = {number: said for number, said in MODELS["mmrl_current"].modules.items() if number != 0x08}
        model = type(MODELS["mmrl_current"])(modules, "5", "0.5", "1.7.2")
        async with worn(MetaWearBoard(model, Traits(absent=style))) as band:
            await band.streams()
            await band.band.send(Haptic(0.0, "right", 1.0, 0.1))
            await asyncio.sleep(0.2)
            assert band.board.haptics == []

    run(scene)


def test_a_board_in_its_bootloader_is_refused():
    async def scene():
        async with worn(MetaWearBoard(traits=Traits(bootloader=True))):
            await asyncio.sleep(5.0)

    with pytest.raises(DeviceError, match=r"right \(E8:C9:8F:52:7B:07\) is in its bootloader .* finish the update"):
        run(scene)


def test_firmware_that_is_too_old_for_raw_samples_is_refused():
    async def scene():
        async with worn(MetaWearBoard("mmrl_fw113"), profile="raw"):
            await asyncio.sleep(8.0)

    with pytest.raises(DeviceError, match=r"firmware 1\.1\.3: too old .* set profile = 'fusion'"):
        run(scene)


# --- a bad radio -----------------------------------------------------------------------------------------


def test_two_bands_lose_packets_and_links_and_every_loss_is_counted():
    async def scene():
        async with emulated_radio(np.random.default_rng(11)) as air:
            bands = []
            for address, name, profile in ((RIGHT, "right", "raw"), (LEFT, "left", "fusion")):
                board = MetaWearBoard(address=address)
                await air.add(MetaWearPeripheral(board), LinkFaults(loss=0.01, write_loss=0.01, burst_s=0.03))
                bands.append(Worn(air, board, name=name, profile=profile))
            listeners = [asyncio.create_task(band.listen()) for band in bands]
            for band in bands:
                await band.streams(300)
                air.cut(band.board.address)
                await band.streams(300)
            await asyncio.sleep(2.0)
            for listener in listeners:
                listener.cancel()
            await asyncio.gather(*listeners, return_exceptions=True)
            for band in bands:
                check_events(band.events)
                check_lost_and_mended(band.events, band.band.entry.name)
                told = band.stream.samples + band.stream.lost
                spread = band.samples[-1].t - band.samples[0].t
                assert told == pytest.approx(100 * spread, abs=12)  # a few lost ones may still be unnoticed
                assert sum(gap.samples for gap in band.stream.latest_gaps) == band.stream.lost
                assert band.stream.gaps == len(band.stream.latest_gaps)

    run(scene, 120)


def turning(t):
    """A band that turns half a radian a second: its heading tells the time."""
    return {"acc": (0.0, 0.0, 9.80665), "gyr": (0.0, 0.0, 0.5), "quat": (math.cos(t / 4), 0.0, 0.0, math.sin(t / 4))}


async def feel(board, what):
    t = now()
    while True:
        while t < now() + 0.15:
            board.sample(t, **what(t))
            t += 0.025
        await asyncio.sleep(0.05)


async def turned(band, count):
    feeling = asyncio.create_task(feel(band.board, turning))
    await band.streams(count)
    feeling.cancel()
    return band.samples[-count // 2 :]


def test_times_and_rates_of_orientations_are_those_of_the_board():
    async def scene():
        async with worn(mode="ndof", faults=LinkFaults(loss=0.01)) as band:
            samples = await turned(band, 1200)
            heading = np.array([2 * math.atan2(sample.quat[3], sample.quat[0]) for sample in samples])
            off = np.array([sample.t for sample in samples]) - heading / 0.5
            off = (off + 2 * math.pi) % (4 * math.pi) - 2 * math.pi
            assert np.percentile(np.abs(off), 95) < 0.002
            gyr = np.array([sample.gyr for sample in samples])
            assert np.median(gyr[:, 2]) == pytest.approx(0.5, abs=0.005)
            assert np.abs(gyr[:, :2]).max() < 0.01

    run(scene, 60)


def ramp(t):
    return {"acc": (0.0, 0.0, 9.80665), "gyr": (0.5 * (t % 60.0), 0.0, 0.0)}


@pytest.mark.parametrize("burst", [0.0, 0.0375, 0.05])
def test_times_of_raw_samples_are_right_to_five_milliseconds(burst):
    async def scene():
        faults = LinkFaults(loss=0.01, burst_s=burst, obeys=False)
        async with worn(faults=faults, profile="raw") as band:
            feeling = asyncio.create_task(feel(band.board, ramp))
            await band.streams(1700)
            feeling.cancel()
            off = np.array([sample.t % 60.0 - sample.gyr[0] / 0.5 for sample in band.samples[200:]])
            off = off[np.abs(off) < 1.0]
            assert len(off) > 1400
            assert np.abs(off).max() < 0.005 + 0.002  # a count of the gyro is 2 ms of this ramp
            assert np.percentile(np.abs(off), 95) < 0.005

    run(scene, 60)


def test_all_outputs_come_where_they_are_wanted():
    async def scene():
        async with worn(mode="ndof", outputs="all") as band:
            samples = await turned(band, 200)
            assert samples[-1].mag == pytest.approx((20.0, 0.0, -40.0), abs=5.0)
            assert samples[-1].gyr == pytest.approx((0.0, 0.0, 0.5), abs=0.01)
            assert samples[-1].acc == pytest.approx((0.0, 0.0, 9.80665), abs=0.1)

    run(scene)


# --- silence ---------------------------------------------------------------------------------------------


def test_outputs_that_stopped_are_asked_for_again_and_the_heading_holds():
    async def scene():
        async with worn() as band:
            await band.streams()
            heading = band.board.sensing.fusion.heading
            band.board.sensing.subscribed.clear()
            band.board.sensing.fusion.mask = 0
            await band.until(lambda: len(band.links) == 3)
            assert band.links == [(True, True), (False, False), (True, False)]
            assert band.board.sensing.fusion.heading == heading
            report = band.band.report()
            assert (report.connections, report.restarts, report.resets) == (1, 0, 0)

    run(scene)


def test_a_fusion_that_stopped_is_started_again_and_its_heading_is_void():
    async def scene():
        async with worn() as band:
            await band.streams()
            band.board.write(b"\x19\x01\x00")
            await band.until(lambda: len(band.links) == 3)
            assert band.links == [(True, True), (False, False), (True, True)]
            report = band.band.report()
            assert (report.connections, report.restarts, report.resets) == (1, 1, 0)

    run(scene)


def test_a_fusion_that_crashed_is_reset():
    async def scene():
        async with worn() as band:
            await band.streams()
            band.board.sensing.fusion.crashed = True
            band.board.write(b"\x19\x0a\x00")  # noticed with the next write
            await band.until(lambda: len(band.links) == 3)
            assert band.links[-1] == (True, True)
            report = band.band.report()
            assert (report.connections, report.resets) == (2, 1)
            assert band.board.reset_uid == 6
            await band.streams()
            check_events(band.events)

    run(scene)


def test_a_link_that_holds_but_carries_nothing_is_left_and_made_again():
    async def scene():
        async with worn() as band:
            await band.streams()
            since = now() - 100.0
            band.air.worsen(RIGHT, LinkFaults(silent=((since, since + 6.0),)))
            await band.until(lambda: (False, False) in band.links, 3.0)
            await band.until(lambda: len(band.links) == 3)
            assert band.links[-1] == (True, False)
            assert band.board.reset_uid == 5

    run(scene)


def test_a_board_that_was_reset_meanwhile_is_set_up_anew():
    async def scene():
        async with worn() as band:
            await band.streams()
            band.board.write(b"\xfe\x01")
            band.air.wake(RIGHT)
            await band.until(lambda: len(band.links) == 3)
            assert band.links == [(True, True), (False, False), (True, True)]
            await band.streams()
            check_events(band.events)

    run(scene)


def test_a_board_that_somebody_else_set_up_meanwhile_is_set_up_anew():
    async def scene():
        async with worn() as band:
            await band.streams()
            band.air.cut(RIGHT, 3.0)
            await band.until(lambda: not band.board.up)
            band.board.write(bytes.fromhex("03032803"))
            await band.until(lambda: len(band.links) == 3)
            assert band.links[-1] == (True, True)

    run(scene)


# --- button, light, motor, battery -----------------------------------------------------------------------


async def press(board, air, times, apart=0.2):
    for _ in range(times):
        for down in (True, False):
            board.press(down)
            air.wake(board.address)
            await asyncio.sleep(apart / 2)


@pytest.mark.parametrize("times", [1, 2, 3])
def test_presses_in_a_row_are_one_tap(times):
    async def scene():
        async with worn() as band:
            await band.streams()
            began = now()
            await press(band.board, band.air, times)
            if times == 3:  # told at once: it stops the robots
                assert [tap.count for tap in band.events if isinstance(tap, Tap)] == [3]
            await asyncio.sleep(0.6)
            (tap,) = [event for event in band.events if isinstance(event, Tap)]
            assert (tap.source, tap.count) == ("right", times)
            assert tap.t == pytest.approx(began + 0.2 * (times - 1), abs=0.03)

    run(scene)


def test_a_light_and_a_vibration():
    async def scene():
        async with worn() as band:
            await band.streams()
            board = band.board
            await band.band.send(Light(0.0, "right", (255, 0, 1)))
            await band.band.send(Haptic(0.0, "right", 0.5, 0.25))
            await asyncio.sleep(0.1)
            assert {colour: pattern[1:3] for colour, pattern in board.lamp.patterns.items()} == {
                "red": b"\x1f\x1f",
                "blue": b"\x01\x01",
            }
            assert board.lamp.playing
            assert [(buzz.strength, buzz.duration, buzz.buzzer) for buzz in board.haptics] == [(0.5, 0.25, False)]
            await band.band.send(Light(0.0, "right", (0, 0, 0)))
            await asyncio.sleep(0.1)
            assert not board.lamp.playing
            assert board.lamp.patterns == {}

    run(scene)


def test_a_band_takes_no_orders_for_others_and_none_that_it_does_not_know():
    async def scene():
        async with worn() as band:
            await band.streams(1)
            await band.band.send(Stop(0.0))
            with pytest.raises(DeviceNotFound, match="'r1' is not the band 'right'"):
                await band.band.send(Haptic(0.0, "r1", 1.0, 0.1))
            with pytest.raises(DeviceError, match="takes a Light or a Haptic"):
                await band.band.send(GoTo(0.0, "right", (0.0, 0.0), 0.1, 1.0))
            with pytest.raises(DeviceError, match="takes a Light or a Haptic"):
                await band.band.send(Haptic(0.0, "right", math.nan, 0.1))

    run(scene)


def test_the_battery_is_asked_for_now_and_then(monkeypatch):
    assert connection.BATTERY_S == 60.0
    monkeypatch.setattr(connection, "BATTERY_S", 4.0)

    async def scene():
        async with worn(MetaWearBoard(traits=Traits(battery=87))) as band:
            await band.streams()
            assert band.band.battery == pytest.approx(0.87)
            band.board.traits = Traits(battery=12)
            await asyncio.sleep(7.0)
            assert band.band.battery == pytest.approx(0.12)

    run(scene, 90)


# --- calibration -----------------------------------------------------------------------------------------


def test_calibration_is_kept_and_given_back(tmp_path):
    async def scene():
        board = MetaWearBoard(traits=Traits(calibrated_after_s=(2.0, 1.0, 1e9)))
        async with worn(board, calibration=tmp_path) as band:
            await band.until(lambda: band.band.report().calibration == "kept")
        (kept,) = tmp_path.glob("*.json")
        assert kept.name == "metawear-e8c98f527b07.json"
        assert "mag" not in kept.read_text()
        again = MetaWearBoard(traits=Traits(calibrated_after_s=(1e9, 1e9, 1e9)))
        async with worn(again, calibration=tmp_path) as band:
            await band.until(lambda: band.band.report().accuracy is not None)
            assert band.band.report().accuracy[:2] == (3, 3)
            assert not again.sensing.fusion.crashed

    run(scene, 60)


# --- a cable ---------------------------------------------------------------------------------------------


def test_a_band_on_a_cable():
    async def scene():
        board = MetaWearBoard("mms_current")
        async with serve_usb(board) as path:
            for profile in ("fusion", "raw"):
                band = Worn(_NoAir, board, address=f"usb:{path}", profile=profile)
                listener = asyncio.create_task(band.listen())
                await band.streams(100)
                report = band.band.report()
                assert (report.board, report.firmware, report.mac) == ("MetaMotion S", "1.7.2", RIGHT)
                check_rest(band.samples)
                check_events(band.events)
                listener.cancel()
                await asyncio.gather(listener, return_exceptions=True)
                assert board.events == {}
                assert not board.up

    run(scene, 60)


def test_a_cable_that_is_not_there_is_told_and_tried_again():
    async def scene():
        band = Worn(_NoAir, MetaWearBoard(), address="usb:/dev/not-there").band
        source = band.source()
        assert not (await anext(source)).up
        assert "/dev/not-there cannot be opened" in band.report().trouble
        await source.aclose()

    run(scene)


class _NoAir:
    radio = None
