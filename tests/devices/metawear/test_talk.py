"""Questions and answers, the handshake and the set-up, against a scripted board."""

import asyncio

import pytest

from armspan.devices.metawear.boards import board_named
from armspan.devices.metawear.entry import MetaWearEntry
from armspan.devices.metawear.handshake import NEEDED, Identity, check_services, meet, reference
from armspan.devices.metawear.setup import NotSetUp, leave, nudge, outputs, set_up
from armspan.devices.metawear.talk import Talk
from armspan.devices.metawear.wire import SERVICE
from armspan.errors import DeviceError, DeviceLost
from fast_time import now, run

ADDRESS = "E8:C9:8F:52:7B:07"
ENTRY = MetaWearEntry("right", ADDRESS)
MMRL = "0180 0000 0280 00010300 0380 0102 0880 0000 0980 00031c 1180 000a0000 1380 0001 1580 0002 "
MMRL += "1980 00030300060002000100 fe80 000603"
TABLE = dict(zip(MMRL.split()[::2], MMRL.split()[1::2], strict=True))
INFORMATION = {"2a26": b"1.7.2", "2a24": b"5", "2a27": b"0.5", "2a29": b"MbientLab Inc", "2a25": b"047D22\0"}


class Scripted:
    """Answers what its table holds, and notes what is written; ``deaf`` loses that many writes first."""

    def __init__(self, answers=(), services=None, deaf=0):
        self.answers = {question: question + rest for question, rest in TABLE.items()}
        self.answers |= {"0b84": "0b841504000005", "118b": "118b01077b528fc9e8"} | dict(answers)
        self.services, self.deaf = services, deaf
        self.written, self.asked_at, self.open, self.most_open = [], [], {}, 0

    async def write(self, data, response=False):
        self.written.append((data.hex(), response))
        self.asked_at.append(now())
        if self.deaf:
            self.deaf -= 1
            return
        answer = self.answers.get(data.hex())
        if callable(answer):
            answer = answer()
        if answer is not None:
            key = data[:2]
            self.open[key] = self.open.get(key, 0) + 1
            self.most_open = max(self.most_open, self.open[key])
            asyncio.get_running_loop().call_later(0.1, self.say, key, bytes.fromhex(answer))

    def say(self, key, data):
        self.open[key] -= 1
        self.heard(data)

    async def read(self, uuid):
        return INFORMATION[uuid[4:8]]

    def talk(self, heard=lambda data: None):
        talk = Talk(self, "right", heard)
        self.heard = talk.hear
        return talk


# --- questions -------------------------------------------------------------------------------------------


def test_an_answer_is_known_by_its_register_and_the_rest_is_heard():
    async def scene():
        heard, board = [], Scripted({"118c": "118c633410"})
        talk = board.talk(heard.append)
        asked = asyncio.create_task(talk.ask(b"\x11\x8c"))
        await asyncio.sleep(0.05)
        talk.hear(b"\x01\x01\x01")
        assert (await asked).hex() == "118c633410"
        talk.hear(bytes.fromhex("118c633410"))  # nobody asked
        assert heard == [b"\x01\x01\x01", bytes.fromhex("118c633410")]

    run(scene)


def test_one_question_at_a_time_is_open_for_each_register():
    async def scene():
        board = Scripted({"118c": "118c633410"})
        talk = board.talk()
        answers = await asyncio.gather(*(talk.ask(b"\x11\x8c") for _ in range(3)), talk.ask(b"\x0b\x84"))
        assert [answer.hex() for answer in answers] == ["118c633410"] * 3 + ["0b841504000005"]
        assert board.most_open == 1

    run(scene)


def test_a_question_that_was_lost_is_asked_again_and_silence_is_none():
    async def scene():
        board = Scripted(deaf=2)
        talk = board.talk()
        assert (await reference(talk)).tick == 0x415
        assert [write for write, _ in board.written] == ["0b84"] * 3
        began = now()
        assert await talk.ask(b"\x19\x8b", tries=2) is None
        assert now() - began == pytest.approx(2.0, abs=0.05)
        with pytest.raises(DeviceLost, match="right did not answer when asked 198b"):
            await talk.learn(b"\x19\x8b", tries=1)

    run(scene)


def test_macros_alone_are_written_with_a_response():
    async def scene():
        board = Scripted()
        await board.talk().tell(b"\x0f\x08", (b"\x09\x08", b"\x0a\x05"))
        assert board.written == [("0f08", True), ("0908", False), ("0a05", False)]

    run(scene)


def test_a_link_that_breaks_is_told_to_everybody_who_waits():
    async def scene():
        talk = Scripted().talk()
        waiting = [asyncio.create_task(talk.ask(b"\x19\x8b")), asyncio.create_task(talk.wait(60.0))]
        await asyncio.sleep(0.1)
        talk.hang_up()
        for one in await asyncio.gather(*waiting, return_exceptions=True):
            assert isinstance(one, DeviceLost)
        with pytest.raises(DeviceLost):
            await talk.tell(b"\x01\x80")

    run(scene)


# --- the handshake ---------------------------------------------------------------------------------------


def test_a_board_is_asked_for_what_is_needed_and_no_more():
    async def scene():
        board = Scripted()
        met = await meet(board.talk(), ENTRY)
        questions = [write for write, _ in board.written]
        assert questions == ["0180", "0280", "0380", "0880", "0980", "1180", "1380", "1580", "1980", "fe80", "118b"]
        assert met.identity == Identity("1.7.2", "5", "0.5", "MbientLab Inc", "047D22", ADDRESS)
        wanted = {module: board_named("mmrl_current").modules[module] for module in NEEDED}
        assert met.board.modules == wanted
        assert met.board.name == "MetaMotion RL"

    run(scene)


@pytest.mark.parametrize("style", ["0880", None])
def test_an_absent_module_answers_two_bytes_or_nothing(style):
    async def scene():
        board = Scripted({"0880": style})
        began = now()
        met = await meet(board.talk(), ENTRY)
        assert not met.board.has(0x08)
        assert met.board.has(0x19)
        assert now() - began < (2.0 if style else 7.0)

    run(scene)


def test_silence_in_the_middle_is_a_lost_link_and_no_absent_module():
    async def scene():
        board = Scripted({"1380": None, "1580": None, "1980": None, "fe80": None, "0b84": None})
        with pytest.raises(DeviceLost):
            await meet(board.talk(), ENTRY)

    run(scene)


@pytest.mark.parametrize(
    ("answers", "settings", "sentence"),
    [
        ({"0980": "098000001c"}, {"profile": "raw"}, "too old for samples with a clock .* of revision 0, 3 is needed"),
        ({"1980": "1980"}, {}, "has no sensor fusion; set profile = 'raw'"),
        ({"1580": "1580"}, {"mode": "ndof"}, "has no magnetometer; set mode = 'imu_plus'"),
        ({"1380": "1380"}, {}, "lacks an accelerometer or a gyro"),
        ({"0380": "03800302"}, {}, "of implementation 3"),
    ],
)
def test_a_board_that_cannot_is_refused_with_what_to_try(answers, settings, sentence):
    async def scene():
        with pytest.raises(DeviceError, match=sentence):
            await meet(Scripted(answers).talk(), MetaWearEntry("right", ADDRESS, **settings))

    run(scene)


def test_what_is_no_metawear_is_refused():
    check_services(Scripted(services=frozenset({SERVICE})), ENTRY)
    with pytest.raises(DeviceError, match="is no MetaWear board"):
        check_services(Scripted(services=frozenset({"0000180f-0000-1000-8000-00805f9b34fb"})), ENTRY)


# --- the set-up ------------------------------------------------------------------------------------------


def test_a_fusion_is_set_up_in_this_order_by_hand():
    async def scene():
        board = Scripted({"1982": "19820213", "0383": "0383280c", "0a0303": None})
        await set_up(board.talk(), ENTRY, board_named("mmrl_current"))
        written = [write for write, _ in board.written]
        assert written[:5] == ["0908", "0a05", "0b0a", "190100", "1903007f"]
        wanted = ["19020213", "0303280c", "13032800", "1982", "0383"]
        at = written.index("19020213")
        assert written[at : at + 5] == wanted
        assert written[written.index("190701") :] == (
            ["190701", "03020100", "13020100", "030101", "130101", "19030800", "190101"]
        )
        assert "010101" in written

    run(scene)


def test_settings_that_do_not_arrive_are_written_again():
    async def scene():
        tellings = iter(["19820002", "19820213", "19820213"])
        board = Scripted({"1982": lambda: next(tellings), "0383": "0383280c"})
        await set_up(board.talk(), ENTRY, board_named("mmrl_current"))
        assert [write for write, _ in board.written].count("19020213") == 2

    run(scene)


def test_a_board_that_keeps_nothing_is_given_up():
    async def scene():
        board = Scripted({"1982": "19820013", "0383": "0383280c"})
        with pytest.raises(NotSetUp, match="right does not keep its settings"):
            await set_up(board.talk(), ENTRY, board_named("mmrl_current"))

    run(scene)


def test_the_numbers_of_processors_are_those_that_the_board_tells():
    async def scene():
        entry = MetaWearEntry("right", ADDRESS, profile="raw")
        numbers = iter(["090204", "090205", "090206"])

        def created():
            return next(numbers)

        board = Scripted(
            {
                "0383": "0383280c",
                "1383": "13832800",
                "09021305ffa00f05": created,
                "09020304ffa01b01040000000000000000000000": created,
                "090209030560113103": created,
            }
        )
        done = await set_up(board.talk(), entry, board_named("mmrl_current"))
        assert done.processor == 6
        assert done.ranges.processors == {6: "fused"}
        written = [write for write, _ in board.written]
        assert written[written.index("09070601") :] == [
            "09070601",
            "090301",
            "13020100",
            "03020100",
            "130101",
            "030101",
        ]

    run(scene)


def test_a_nudge_does_not_touch_the_filter_and_the_end_is_said_last():
    assert b"\x19\x01\x01" not in nudge(ENTRY)
    assert nudge(ENTRY)[-1] == bytes.fromhex("19030800")
    last = [write.hex() for write in leave(ENTRY, board_named("mms"))]
    assert last[-1] == "fe06"
    assert last.index("0a05") < last.index("fe06")
    assert {"190100", "1903007f", "030100", "130100", "150100", "020201", "190700", "010100"} <= set(last)


def test_orientations_complete_a_sample_and_come_last():
    whole = MetaWearEntry("right", ADDRESS, mode="ndof", outputs="all")
    assert outputs(ENTRY) == ("quaternion",)
    assert outputs(whole) == ("corrected_acc", "corrected_gyro", "corrected_mag", "quaternion")
