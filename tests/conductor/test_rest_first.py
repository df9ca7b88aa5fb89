import pytest

from armspan.conductor import BandSettings, Conductor, Settings
from armspan.records import Body, ImuSample, Press, Say, Sheet, Tick

SETTINGS = Settings(
    Body(1.6, (0.06, 0.15, 0.22), 0.72),
    Sheet(0.9, 0.6),
    (BandSettings("wrist"),),
    ("amber",),
    stops=((0.1, 0.1), (0.8, 0.1), (0.8, 0.5)),
)


def cues(quat, seconds, shaken_until=0.0):
    """What a person is asked while the arm lies still, with the times at which it is asked."""
    conductor, said = Conductor(SETTINGS), []
    for k in range(int(seconds * 100)):
        t = k / 100
        rate = 1.0 if t < shaken_until else 0.0
        events = [ImuSample(t, "wrist", (0.0, 0.0, 9.81), (rate, 0.0, 0.0), quat=quat)]
        events += [Press(t, "setup")] if k == 50 else []
        events += [Tick(t)] if k % 5 == 0 else []
        for event in events:
            said += [(round(t, 2), o.cue) for o in conductor.step(event) if isinstance(o, Say)]
    return said


def test_a_raw_band_is_rested_before_anything_else():
    (_, first), (stretched, second) = cues(None, 7.0)
    assert (first, second) == ("rest", "stretch")
    assert stretched == pytest.approx(0.5 + 0.8 + 0.5 + 4.0, abs=0.15)


def test_the_rest_starts_anew_when_the_arm_moves():
    assert cues(None, 6.0, shaken_until=3.0) == [(0.5, "rest")]


def test_a_band_with_its_own_fusion_needs_no_rest():
    assert cues((1.0, 0.0, 0.0, 0.0), 1.0) == [(0.5, "stretch")]
