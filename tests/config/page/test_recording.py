import msgspec
import pytest

from armspan.config.demo_room import page_room
from armspan.config.page.recording import ready
from armspan.errors import ConfigError, DataError
from armspan.records import TakeEnded
from armspan.web.views.gestures_host import Asked

ASKED = Asked(("stop", "mixing"), 2, "p01", 70.0)


def asked(**changes):
    return msgspec.structs.replace(ASKED, **changes)


def test_what_is_asked_is_made_ready(tmp_path):
    recorded = ready(page_room(1), tmp_path, tmp_path / "takes", asked(person=" p02 "))
    recording = recorded.house.recorder.recording
    assert (recording.gestures, recording.person, recording.wrists) == (("stop", "mixing"), "p02", ("right", "left"))
    assert recorded.progress == (0, 8)  # two gestures with one for practice, two pieces of everyday motion
    assert recorded.house.simulated
    assert not recorded.hurried


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"gestures": (), "null_s": 0.0}, "nothing is to be recorded"),
        ({"gestures": ("stop", " stop")}, "asked for twice"),
        ({"gestures": ("null",)}, "is no gesture: enter its seconds"),
        ({"gestures": ("a/b",)}, "cannot be a folder's name"),
        ({"gestures": ("Stop", "stop")}, "differ by case only"),
        ({"gestures": ("wave",)}, "virtual person"),
        ({"takes": 0}, "expected 1 to 50"),
        ({"takes": 51}, "expected 1 to 50"),
        ({"null_s": -1.0}, "expected 0 to 3600"),
        ({"null_s": float("nan")}, "expected 0 to 3600"),
        ({"person": "Anna B."}, "person code"),
        ({"person": ""}, "person code"),
    ],
)
def test_what_cannot_be_is_told(tmp_path, changes, words):
    with pytest.raises(ConfigError, match=words):
        ready(page_room(1), tmp_path, tmp_path / "takes", asked(**changes))


def test_a_file_in_the_folders_place_is_told(tmp_path):
    (tmp_path / "takes").write_text("")
    with pytest.raises(DataError, match="is a file"):
        ready(page_room(1), tmp_path, tmp_path / "takes", ASKED)


def test_a_room_without_a_wristband_records_nothing(tmp_path):
    room = page_room(1)
    bands = tuple(msgspec.structs.replace(band, segment="upperarm") for band in room.bands)
    with pytest.raises(ConfigError, match="no band is worn on a wrist"):
        ready(msgspec.structs.replace(room, bands=bands), tmp_path, tmp_path / "takes", ASKED)


def test_a_full_disk_is_told_in_a_sentence(tmp_path):
    recorded = ready(page_room(1), tmp_path, tmp_path / "takes", ASKED)

    def full(record):
        raise OSError(28, "No space left on device")

    recorded._writer = full
    full.folder = tmp_path / "takes"
    with pytest.raises(DataError, match="make room for it"):
        recorded(TakeEnded(1.0, 0.5, "stop", "p01", 1, False))
