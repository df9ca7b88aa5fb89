import os

import pytest

from armspan.body.picture.native import stderr_kept


def test_what_is_written_past_python_is_kept_and_stderr_comes_back(capfd):
    with stderr_kept() as said:
        os.write(2, b"INFO: hello\n")
    os.write(2, b"after\n")
    said_then = capfd.readouterr().err
    assert said_then == "after\n"
    assert said.closed


def test_it_can_be_read_within(capfd):
    with stderr_kept() as said:
        os.write(2, b"a complaint")
        said.seek(0)
        assert said.read() == b"a complaint"
    assert capfd.readouterr().err == ""


def test_an_error_is_raised_and_stderr_comes_back(capfd):
    def fails():
        with stderr_kept():
            os.write(2, b"noise")
            raise ValueError("mine")

    with pytest.raises(ValueError, match="mine"):
        fails()
    os.write(2, b"after")
    assert capfd.readouterr().err == "after"


def test_a_process_without_stderr_goes_on(monkeypatch):
    def closed(descriptor):
        raise OSError(9, "Bad file descriptor")

    monkeypatch.setattr(os, "dup", closed)
    with stderr_kept() as said:
        assert said.read() == b""
