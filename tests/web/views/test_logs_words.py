import pytest

from armspan.web.film import Film, Opening
from armspan.web.views.logs_player import place_words
from armspan.web.views.logs_words import happened_words, length_words, size_words


@pytest.mark.parametrize(
    ("counts", "words"),
    [
        ({"Selected": 1, "Gesture": 12, "Stop": 3, "Tick": 900}, "1 selection, 12 gestures, 3 stops"),
        ({"TakeEnded": 7}, "7 takes"),
        ({"Tick": 5}, "nothing was chosen, made or stopped"),
    ],
)
def test_what_happened(counts, words):
    assert happened_words(counts) == words


def test_lengths_and_sizes():
    assert [length_words(s) for s in (None, 0.4, 59.9, 3725.0)] == ["not known", "0:00 min", "0:59 min", "62:05 min"]
    assert [size_words(n) for n in (0, 1400, 260_204)] == ["0 kB", "1 kB", "0.3 MB"]


def test_a_film_says_how_far_it_is_made_and_what_it_lacks():
    film = Film(Opening(120.0, simulated=False, note="The log was cut off."))
    assert place_words(film) == "0:00 min of 2:00 min; ready up to 0:00 min. The log was cut off."
    film.whole, film.position = True, 61.0
    assert place_words(film) == "1:01 min of 2:00 min. The log was cut off."
