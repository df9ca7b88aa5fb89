"""The fusion's calibration on disk."""

import pytest

from armspan.devices.metawear.calibration import Calibration, Kept, Shelf, is_good
from armspan.devices.metawear.notifications import CalibrationState
from armspan.errors import DeviceError

MAC = "E8:C9:8F:52:7B:07"
ACC, GYRO, MAG = "00112233445566778899", "aabbccddeeff00112233", "0102030405060708090a"


def kept(**chips):
    return Calibration(MAC, "1.7.2", {chip: Kept(*what) for chip, what in chips.items()})


def test_what_is_kept_is_given_back_for_the_chips_of_the_mode(tmp_path):
    shelf = Shelf(tmp_path / "new")
    assert shelf.writes(MAC, "imu_plus") == ()
    shelf.save(kept(acc=(ACC, 3), gyro=(GYRO, 3), mag=(MAG, 3)))
    assert [write.hex() for write in shelf.writes(MAC, "imu_plus")] == ["190c" + ACC, "190d" + GYRO]
    assert [write.hex() for write in shelf.writes(MAC, "ndof")] == ["190c" + ACC, "190d" + GYRO, "190e" + MAG]
    assert shelf.writes("E8:C9:8F:52:7B:08", "ndof") == ()


@pytest.mark.parametrize("bad", [(MAG, 2), ("0102", 3), ("no digits", 3), (MAG, 4)])
def test_a_magnetometers_data_that_are_not_good_are_never_given_back(tmp_path, bad):
    shelf = Shelf(tmp_path)
    shelf.save(kept(acc=(ACC, 3), gyro=(GYRO, 3), mag=bad))
    assert [write.hex() for write in shelf.writes(MAC, "ndof")] == ["190c" + ACC, "190d" + GYRO]


def test_a_mode_without_magnetometer_forgets_none(tmp_path):
    shelf = Shelf(tmp_path)
    shelf.save(kept(acc=(ACC, 3), gyro=(GYRO, 3), mag=(MAG, 3)))
    shelf.save(kept(acc=(GYRO, 3), gyro=(ACC, 3)))
    assert shelf.load(MAC) == kept(acc=(GYRO, 3), gyro=(ACC, 3), mag=(MAG, 3))


@pytest.mark.parametrize("text", [b"", b"{", b'{"mac": 3}', b"\xff\xfe"])
def test_a_file_that_cannot_be_read_is_as_good_as_none(tmp_path, text):
    shelf = Shelf(tmp_path)
    shelf.path(MAC).write_bytes(text)
    assert shelf.writes(MAC, "imu_plus") == ()
    shelf.save(kept(acc=(ACC, 3), gyro=(GYRO, 3)))
    assert len(shelf.writes(MAC, "imu_plus")) == 2


def test_without_a_folder_nothing_is_kept():
    shelf = Shelf(None)
    shelf.save(kept(acc=(ACC, 3)))
    assert shelf.load(MAC) is None


def test_a_folder_that_cannot_be_written_to_is_told(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(DeviceError, match="cannot be kept in"):
        Shelf(tmp_path / "file").save(kept(acc=(ACC, 3)))


@pytest.mark.parametrize(
    ("state", "mode", "good"),
    [
        ((3, 3, 0), "imu_plus", True),
        ((3, 2, 3), "imu_plus", False),
        ((3, 3, 2), "ndof", False),
        ((3, 3, 3), "ndof", True),
    ],
)
def test_all_the_chips_of_a_mode_must_be_calibrated(state, mode, good):
    assert is_good(CalibrationState(*state), mode) == good
