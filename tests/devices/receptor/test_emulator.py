import numpy as np

from armspan.devices.receptor.emulator import EmulatedReceptor
from armspan.records import Hit


def played(board, until, step=0.01):
    return [line for k in range(round(until / step) + 1) for line in board.advance(k * step)]


def test_it_says_hit_again_and_again_until_it_is_dark():
    board = EmulatedReceptor(np.random.default_rng(0), repeat=0.2)
    board.hear(Hit(0.0, "amber", True))
    assert played(board, 0.95) == [b"hit amber\r\n"] * 5
    board.hear(Hit(1.0, "amber", False))
    assert board.advance(1.0) == [b"lost amber\r\n"]
    assert board.advance(9.0) == []


def test_it_bounces_and_ends_where_it_should():
    board = EmulatedReceptor(np.random.default_rng(1), repeat=0.0, bounces=5, token="quiet-river-9", end=b"\n")
    board.notice(0.0, "amber", True)
    said = played(board, 0.2)
    assert len(said) % 2 == 1
    assert len(said) > 1
    assert said == [b"hit amber token=quiet-river-9\n", b"lost amber token=quiet-river-9\n"] * (len(said) // 2) + [
        b"hit amber token=quiet-river-9\n"
    ]


def test_some_of_it_gets_lost():
    board = EmulatedReceptor(np.random.default_rng(2), repeat=0.01, lost=0.3)
    board.notice(0.0, "amber", True)
    assert 600 < len(played(board, 10.0)) < 800
