import pytest

from armspan.web.film import Film, Opening, Second, packed


class Clock:
    """A clock that is set by hand."""

    def __init__(self):
        self.t = 100.0

    def __call__(self):
        return self.t


def second(k, number=1):
    return packed(Second({"number": number, "robots": []}, [{"t": k + i / 20, "room": number} for i in range(20)]))


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def film(clock):
    found = Film(Opening(2.5, simulated=True), base=7, clock=clock)
    for k in range(3):
        found.add(second(k, number=1 + (k > 1)))
    found.whole = True
    return found


def test_it_plays_at_its_speed_and_ends_where_the_log_ends(film, clock):
    film.play(True)
    clock.t += 0.5
    assert film.move()
    assert film.position == 0.5
    film.speed = 4
    clock.t += 0.25
    film.move()
    assert film.position == 1.5
    clock.t += 60
    assert film.move()
    assert (film.position, film.playing) == (2.5, False)
    assert not film.move()


def test_while_it_pauses_time_does_not_count(film, clock):
    film.play(True)
    clock.t += 1
    film.move()
    film.play(False)
    clock.t += 50
    assert not film.move()
    film.play(True)
    clock.t += 0.25
    film.move()
    assert film.position == 1.25


def test_played_again_at_the_end_it_begins_anew(film):
    film.seek(99)
    assert film.position == 2.5
    film.play(True)
    assert film.position == 0.0


def test_what_is_not_made_yet_is_waited_for(clock):
    film = Film(Opening(3600, simulated=False), clock=clock)
    assert (film.room(), film.frame()) == (None, {"t": 0.0, "room": 0})
    film.add(second(0))
    film.play(True)
    clock.t += 5
    film.move()
    assert (film.position, film.playing, film.ready) == (1.0, True, 1.0)
    assert film.frame()["t"] == 0.95
    film.add(second(1))
    clock.t += 0.5
    film.move()
    assert film.position == 1.5


def test_the_frame_is_that_of_the_place_and_its_room_is_new_to_browsers(film):
    film.seek(1.26)
    assert film.frame() == {"t": 1.25, "room": 8}
    assert film.room() == {"number": 8, "robots": []}
    film.seek(2.2)
    assert film.frame()["room"] == film.room()["number"] == 9
