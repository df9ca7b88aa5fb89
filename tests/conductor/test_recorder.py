"""Recordings of a puppet with two arms: what it is told, and the takes that come of it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from armspan.conductor import BandSettings
from armspan.conductor.recorder import Recorder
from armspan.conductor.recorder_plan import Recording, asks_of
from armspan.config.take_files import COLUMNS
from armspan.errors import ConfigError
from armspan.frames import rotation_from_quaternion, yaw_rotation
from armspan.records import ImuSample, Link, Press, Say, TakeEnded, Tap, Tick
from puppet import quaternion, settings

WORN = {"r": np.array([0.9, 0.1, -0.3, 0.3]), "l": np.array([0.2, 0.7, 0.1, -0.6])}
HEADING = {"r": -2.0, "l": 0.7}
LATE = {"r": 0.0, "l": 0.0037}
"""How the bands sit and where their earths' x point, and how long after the right band the left one samples."""

BANDS = (BandSettings("r"), BandSettings("l", arm="left"))
REACTION, RAISING, HIGH = 0.4, 1.0, 1.5
"""The puppet waits, raises its forearms by three half radians in a second, holds, lowers them in a second."""


class Player:
    """Does what a recorder says; ``hold`` [s] is kept up high, ``lazy`` moves nothing, ``stuck`` never comes down."""

    def __init__(self, *, bands=BANDS, hold=0.3, **wanted):
        self.recorder = Recorder(settings(bands=bands, robots=()), Recording(**wanted))
        self.bands, self.hold = [band.name for band in bands], hold
        self.lazy = self.stuck = self.restless = False
        self.t, self.outputs, self.events, self.takes = 0.0, [], [], []
        self.down, self.since, self.cues = np.pi / 2, None, []
        self.silent = {}

    def tell(self, event):
        self.events.append(event)
        for output in self.recorder.step(event):
            self.outputs.append(output)
            if isinstance(output, Say):
                self._hear(output.cue)
            elif isinstance(output, TakeEnded):
                self.takes.append(self.recorder.finished.popleft())

    def _hear(self, cue):
        verb, _, _ = cue.partition(":")
        if verb == "stretch":
            self.down, self.since = 0.0, None
        elif verb in ("hang", "relax"):
            self.down = np.pi / 2
        elif verb == "gesture" and not self.lazy:
            self.make()

    def make(self):
        self.since = self.t + REACTION
        self.cues.append(self.t)

    def dip(self, t):
        """How far the forearms point down [rad] at ``t`` [s], and how fast that grows."""
        s = -1.0 if self.since is None else t - self.since
        if s < 0:
            return self.down, 0.0
        if s < RAISING:
            share, pace = 0.5 - 0.5 * np.cos(np.pi * s / RAISING), 0.5 * np.pi / RAISING * np.sin(np.pi * s / RAISING)
        elif s < RAISING + self.hold or self.stuck:
            share, pace = 1.0, 0.0
        else:
            s = min(s - self.hold, 2 * RAISING)
            share, pace = 0.5 - 0.5 * np.cos(np.pi * s / RAISING), 0.5 * np.pi / RAISING * np.sin(np.pi * s / RAISING)
        return self.down - 2 * HIGH * share / 2, -HIGH * pace

    def sample(self, name, t):
        angle, rate = self.dip(t)
        attitude = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
        worn = rotation_from_quaternion(WORN[name] / np.linalg.norm(WORN[name]))
        earth_from_sensor = yaw_rotation(HEADING[name]) @ attitude @ worn
        turning = yaw_rotation(HEADING[name]) @ [0.0, rate + (2.0 if self.restless else 0.0), 0.0]
        gyr, acc = earth_from_sensor.T @ turning, 9.80665 * earth_from_sensor[2]
        return ImuSample(t, name, tuple(acc.tolist()), tuple(gyr.tolist()), None, quaternion(earth_from_sensor))

    def step(self):
        self.t = round(self.t + 0.05, 9)
        for k in range(5):
            for name in self.bands:
                t = self.t - 0.04 + 0.01 * k - LATE[name]
                if not self.silent.get(name, lambda _: False)(t):
                    self.tell(self.sample(name, t))
        self.tell(Tick(self.t))

    def run(self, seconds):
        end = self.t + seconds
        while self.t < end - 1e-9:
            self.step()
        return self

    def until(self, condition, within=200.0):
        end = self.t + within
        while not condition():
            assert self.t < end, self.said()
            self.step()
        return self

    def begin(self):
        self.run(0.5)
        self.tell(Press(self.t, "setup"))
        return self

    def record(self, within=300.0):
        """The whole recording."""
        return self.begin().until(lambda: "done" in self.said(), within)

    def said(self):
        return [output.cue or output.text for output in self.outputs if isinstance(output, Say)]

    def words(self):
        return [output.text for output in self.outputs if isinstance(output, Say)]

    def ended(self):
        return [output for output in self.outputs if isinstance(output, TakeEnded)]


@pytest.fixture(scope="module")
def two():
    """Two gestures, two takes each, recorded without trouble; the first has three takes already."""
    return Player(gestures=("stop", "wave"), takes=2, person="ada", first={"stop": 4}).record()


def test_what_a_person_is_told(two):
    block = ["3", "2", "1"]
    assert two.said()[:3] == ["stretch", "hang", "mounted"]
    assert two.words()[0] == "Stretch both arms straight forward, level, palm down, and hold still"
    told = two.said()[3:]
    assert told[0] == "Next: stop (forearms crossed before the chest), for practice"
    assert told[1:6] == [*block, "gesture:stop", "relax"]
    assert told[6:12] == ["Next: stop, 1 of 2", *block, "gesture:stop", "relax"]
    assert told[18:24] == ["Next: wave, for practice", *block, "gesture:wave", "relax"]
    assert told[36:] == ["done"]


def test_every_take_is_told_with_its_number(two):
    assert [(record.label, record.number, record.practice) for record in two.ended()] == [
        ("stop", 4, True),
        ("stop", 5, False),
        ("stop", 6, False),
        ("wave", 1, True),
        ("wave", 2, False),
        ("wave", 3, False),
    ]
    assert {record.person for record in two.ended()} == {"ada"}
    for record, done, cue in zip(two.ended(), two.takes, two.cues, strict=True):
        take = done.take
        assert (take.label, take.number, take.practice) == (record.label, record.number, record.practice)
        assert record.started == pytest.approx(done.start + take.gesture[0])
        assert record.started == pytest.approx(cue + REACTION, abs=0.15)
        assert done.note == ""


def test_a_take_has_both_bands_on_one_clock(two):
    for done in two.takes:
        take = done.take
        assert take.columns == COLUMNS
        assert take.times[0] == 0.0
        assert_allclose(np.diff(take.times), 0.01, atol=1e-9)
        assert np.isfinite(take.values).all()


def test_rows_are_what_the_arms_did(two):
    player = Player(gestures=("wave",), takes=1)
    for done, cue in zip(two.takes, two.cues, strict=True):
        player.since = cue + REACTION
        angle, rate = np.array([player.dip(done.start + t) for t in done.take.times]).T
        for side in (0, 10):
            q, acc, gyr = np.split(done.take.values[:, side : side + 10], [4, 7], axis=1)
            assert_allclose(np.abs(q[:, 1]), np.abs(np.sin(angle / 2)), atol=2e-3)
            assert_allclose(np.sign(q[:, 1]) * 2 * np.arccos(q[:, 3]), angle, atol=4e-3)
            assert_allclose(q[:, [0, 2]], 0.0, atol=1e-6)
            assert_allclose(acc, 0.0, atol=1e-6)
            assert_allclose(gyr[:, 1], rate, atol=0.05)
            assert_allclose(gyr[:, [0, 2]], 0.0, atol=1e-6)


def test_the_gesture_is_found_with_a_second_or_two_around_it(two):
    for done, cue in zip(two.takes, two.cues, strict=True):
        first, last = done.take.gesture
        assert done.start + first == pytest.approx(cue + REACTION, abs=0.15)
        assert done.start + last == pytest.approx(cue + REACTION + 2 * RAISING + two.hold, abs=0.15)
        assert 1.0 <= first <= 2.0
        assert 1.0 <= done.take.seconds - last <= 2.0


def test_a_pose_that_is_held_is_not_the_end():
    player = Player(gestures=("raise_both",), takes=1, hold=2.0).record()
    for done in player.takes:
        first, last = done.take.gesture
        assert last - first == pytest.approx(2 * RAISING + 2.0, abs=0.25)
    assert [done.note for done in player.takes] == ["", ""]


def test_who_never_comes_back_is_not_waited_for_for_ever():
    player = Player(gestures=("wave",), takes=1)
    player.stuck = True
    player.begin().until(lambda: player.takes)
    told = [
        output.t for output in player.outputs if isinstance(output, Say) and output.cue in ("gesture:wave", "relax")
    ]
    assert told[1] - told[0] <= 8.05
    assert player.takes[0].take.seconds < 12.0


def test_who_moves_without_end_is_stopped_after_eight_seconds():
    player = Player(gestures=("wave",), takes=1)
    player.begin().until(lambda: "gesture:wave" in player.said())
    player.restless, start = True, player.t
    player.until(lambda: player.said()[-1] == "relax")
    assert player.t - start == pytest.approx(8.0, abs=0.06)


def test_nothing_moved_is_kept_as_practice_and_asked_again_at_once():
    player = Player(gestures=("wave",), takes=2)
    player.begin().until(lambda: len(player.takes) == 1)
    player.lazy = True
    player.until(lambda: len(player.takes) == 2)
    player.lazy = False
    player.until(lambda: "done" in player.said())
    notes = [(done.take.number, done.note, done.take.practice, done.take.gesture is None) for done in player.takes]
    assert notes == [
        (1, "", True, False),
        (2, "nothing moved", True, True),
        (3, "", False, False),
        (4, "", False, False),
    ]
    assert "That take does not count: nothing moved" in player.words()
    assert "Next: wave, 1 of 2, once more" in player.words()


def test_who_never_moves_is_not_asked_for_ever():
    player = Player(gestures=("wave", "stop"), takes=1)
    player.lazy = True
    player.record(within=400)
    assert len(player.takes) == 12  # two gestures, two takes, three tries
    assert all(done.note == "nothing moved" and done.take.practice for done in player.takes)


def test_standing_still_is_the_initial_pose():
    player = Player(gestures=("initial",), takes=1).record()
    assert [done.note for done in player.takes] == ["", ""]
    take = player.takes[1].take
    assert take.gesture == pytest.approx((1.0, 3.0))
    assert take.seconds == pytest.approx(4.0, abs=0.02)


def silenced(seconds, name="l"):
    """A recording in which a band falls silent for so long, amidst the first counted gesture."""
    player = Player(gestures=("wave",), takes=1)
    player.begin().until(lambda: player.said().count("gesture:wave") == 2)
    start = player.t + 1.0
    player.silent[name] = lambda t: start < t < start + seconds
    player.until(lambda: "done" in player.said())
    return player, start


def test_a_long_silence_is_asked_again():
    player, _ = silenced(0.7)
    _, spoilt, good = player.takes
    assert spoilt.note.startswith("the band left was silent for 0.7")
    assert (spoilt.take.practice, good.take.practice, good.note) == (True, False, "")


@pytest.mark.parametrize(("seconds", "empty"), [(0.3, True), (0.12, True), (0.07, False)])
def test_a_gap_is_left_empty_and_a_short_one_bridged(seconds, empty):
    player, start = silenced(seconds)
    _, done = player.takes
    assert done.note == ""
    missing = np.isnan(done.take.values)
    assert not missing[:, :10].any()
    assert (missing[:, 10:].any(axis=1) == missing[:, 10:].all(axis=1)).all()
    inside = (done.take.times + done.start > start + 0.011) & (done.take.times + done.start < start + seconds - 0.011)
    assert missing[inside, 10].all() == empty
    assert missing[:, 10].sum() == pytest.approx(100 * seconds if empty else 0, abs=2)


def test_no_take_begins_while_a_band_is_silent():
    player = Player(gestures=("wave",), takes=1)
    player.begin().until(lambda: player.said()[-1].startswith("Next"))
    player.silent["l"] = lambda _: True
    player.run(15.0)
    assert player.words()[-1] == "Nothing is heard of l: is the band on and near?"
    assert "3" not in player.words()
    player.silent.clear()
    player.run(2.0)
    assert "3" in player.words()


def test_no_take_begins_while_arms_move():
    player = Player(gestures=("wave",), takes=1)
    player.begin().until(lambda: player.said()[-1].startswith("Next"))
    player.restless = True
    player.run(13.0)
    assert player.words()[-1] == "Let your arms hang, and hold still for a moment"
    assert "3" not in player.words()


def test_double_clicks_start_and_end_a_take():
    player = Player(gestures=("wave",), takes=1, taps=True)
    player.lazy = True  # no word tells it to begin
    player.begin()
    for _ in range(2):
        player.until(lambda: player.said()[-1].startswith("Double click"))
        player.run(4.0)
        player.tell(Tap(player.t, "l", 1))
        assert not player.said()[-1].startswith("gesture")
        player.tell(Tap(player.t, "l", 2))
        assert player.said()[-1] == "gesture:wave"
        player.make()
        player.run(4.0)
        player.tell(Tap(player.t, "r", 2))
        player.run(2.0)
    assert player.said()[-1] == "done"
    assert not {"3", "2", "1"} & set(player.said())
    for done, cue in zip(player.takes, player.cues, strict=True):
        assert done.note == ""
        assert done.start + done.take.gesture[0] == pytest.approx(cue + REACTION, abs=0.15)
        assert 1.0 <= done.take.gesture[0] <= 2.0


def test_without_taps_a_double_click_does_nothing():
    player = Player(gestures=("wave",), takes=1)
    player.begin().run(9.0)
    before = list(player.outputs)
    player.tell(Tap(player.t, "l", 2))
    assert player.outputs == before


def test_everyday_motion_comes_in_pieces_of_a_minute_at_most():
    player = Player(gestures=(), takes=1, null_s=90.0).record()
    assert [cue for cue in player.said() if cue.startswith("everyday")] == ["everyday:45"] * 2
    for done in player.takes:
        take = done.take
        assert (take.label, take.practice, take.gesture, done.note) == ("null", False, None, "")
        assert take.seconds == pytest.approx(45.0, abs=0.02)
        assert np.isfinite(take.values).all()


def test_one_band_gives_ten_columns():
    left = (BandSettings("r"), BandSettings("l", arm="left"))
    player = Player(bands=left, gestures=("wave",), takes=1, wrists=("left",)).record()
    assert player.takes[1].take.columns == COLUMNS[10:]
    assert player.takes[1].note == ""
    with pytest.raises(ConfigError, match="no band is worn on the left wrist, only on: right"):
        Player(bands=BANDS[:1], gestures=("wave",), takes=1)


def test_a_recording_can_be_ended():
    player = Player(gestures=("wave",), takes=1)
    player.begin().run(12.0)
    player.tell(Press(player.t, "stop"))
    assert player.said()[-1] == "done"
    count = len(player.outputs)
    player.run(20.0)
    player.tell(Press(player.t, "stop"))
    player.tell(Press(player.t, "setup"))
    assert len(player.outputs) == count
    other = Player(gestures=("wave",), takes=1).begin()
    other.tell(Press(other.t, "quit"))
    count = len(other.outputs)
    assert len(other.run(20.0).outputs) == count


def test_a_lost_link_is_told():
    player = Player(gestures=("wave",), takes=1)
    player.tell(Link(0.0, "l", False))
    assert player.words() == ["l is out of reach"]


def test_the_same_events_give_the_same_words_and_takes(two):
    again = Recorder(two.recorder.settings, two.recorder.recording)
    outputs = [output for event in two.events for output in again.step(event)]
    assert outputs == two.outputs
    for old, new in zip(two.takes, again.finished, strict=True):
        assert_allclose(new.take.values, old.take.values, atol=0)
        assert (new.start, new.note) == (old.start, old.note)


# --- the order ---------------------------------------------------------------------------------------------


def order(**wanted):
    return [("*" if ask.practice else "") + ask.label for ask in asks_of(Recording(**wanted))]


def test_gestures_come_in_blocks_unless_they_are_mixed():
    assert order(gestures=("a", "b"), takes=2) == ["*a", "a", "a", "*b", "b", "b"]
    labels = ("a", "b", "c")
    mixed = order(gestures=labels, takes=4, shuffle=True, dice=3)
    assert mixed[:3] == ["*a", "*b", "*c"]
    rounds = [mixed[k : k + 3] for k in range(3, 15, 3)]
    assert all(sorted(round_) == list(labels) for round_ in rounds)
    assert len({tuple(round_) for round_ in rounds}) > 1
    assert order(gestures=labels, takes=4, shuffle=True, dice=3) == mixed
    assert order(gestures=labels, takes=4, shuffle=True, dice=4) != mixed


@pytest.mark.parametrize(("seconds", "pieces"), [(0.0, []), (60.0, [60.0]), (61.0, [30.5, 30.5]), (600.0, [60.0] * 10)])
def test_pieces_of_everyday_motion(seconds, pieces):
    asks = asks_of(Recording(("a",), 1, null_s=seconds))
    assert [ask.seconds for ask in asks[2:]] == pieces
    assert [ask.place for ask in asks[2:]] == list(range(1, len(pieces) + 1))


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ({"takes": 0}, "0 takes of a gesture"),
        ({"null_s": -1.0}, "-1 s of everyday motion"),
        ({"null_s": float("inf")}, "inf s of everyday motion"),
        ({"gestures": ("a", "null")}, "record it with --null"),
        ({"gestures": ()}, "nothing is to be recorded"),
    ],
)
def test_what_cannot_be_recorded(wanted, words):
    with pytest.raises(ConfigError, match=words):
        Recording(**{"gestures": ("a",), "takes": 1} | wanted)
