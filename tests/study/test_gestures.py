from armspan.records import Gesture, ImuSample, Press
from armspan.study.gestures import gestures_of


def at(t: float) -> ImuSample:
    return ImuSample(t, "right", (0.0, 0.0, 9.8), (0.0, 0.0, 0.0))


def test_gestures_are_held_against_what_was_truly_made() -> None:
    records = [
        at(0.0),
        Press(10.0, "truth", "wave"),
        Gesture(11.5, 10.5, "right", "wave", 0.9),
        Press(12.0, "truth", ""),
        Gesture(20.0, 19.0, "right", "stop", 0.8),
        Press(30.0, "truth", "stop"),
        Press(33.0, "truth", ""),
        at(3600.0),
    ]
    account = gestures_of(records)
    assert [(entry.start, entry.end, entry.label) for entry in account.made] == [(10, 12, "wave"), (30, 33, "stop")]
    assert account.score is not None
    assert (account.score.hits, account.score.deletions, account.score.insertions) == (1, 1, 1)
    assert account.document()["recognised"] == 2


def test_without_a_truth_gestures_are_only_counted() -> None:
    account = gestures_of([at(0.0), Gesture(11.5, 10.5, "right", "wave", 0.9)])
    assert account.document() == {"made": 0, "recognised": 1, "score": None}
