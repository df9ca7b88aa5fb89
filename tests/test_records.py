import math
from typing import get_args

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from armspan import records as rec
from armspan.records import COMMANDS, EVENTS, OUTPUTS, Record, is_finite
from record_strategies import records

EXACT = settings(derandomize=True, database=None, deadline=None, max_examples=200)
ANY = msgspec.json.Decoder(rec.Event | rec.Output)

SAMPLE = rec.ImuSample(t=0.5, source="right_wrist", acc=(0.1, 0.2, 9.8), gyr=(1e-3, -0.0, 2.0))
POINTED = rec.Pointed(
    t=1.0, source="right_wrist", xy=(0.3, 0.4), covariance=((1e-4, 2e-5), (2e-5, 3e-4)), robot="cellulo_1"
)


def leaves(value):
    """The floats in a record or tuple, each with the path to it."""
    if isinstance(value, float):
        yield (), value
    items = enumerate(value) if isinstance(value, tuple) else ()
    if isinstance(value, Record):
        items = ((name, getattr(value, name)) for name in value.__struct_fields__)
    for key, item in items:
        yield from (((key, *path), leaf) for path, leaf in leaves(item))


def replaced(value, path, leaf):
    if not path:
        return leaf
    key, *rest = path
    if isinstance(value, Record):
        return msgspec.structs.replace(value, **{key: replaced(getattr(value, key), rest, leaf)})
    return (*value[:key], replaced(value[key], rest, leaf), *value[key + 1 :])


@EXACT
@given(records())
def test_nothing_can_be_changed(record):
    for name in record.__struct_fields__:
        with pytest.raises(AttributeError, match="immutable"):
            setattr(record, name, getattr(record, name))


@EXACT
@given(records())
def test_a_record_equals_one_with_the_same_values_and_no_other(record):
    same = type(record)(*(getattr(record, name) for name in record.__struct_fields__))
    assert same == record
    assert hash(same) == hash(record)
    for path, leaf in leaves(record):
        nearest = math.nextafter(leaf, 1.0 if leaf == 0.0 else 0.0)
        assert replaced(record, path, nearest) != record


def test_types_with_the_same_values_differ():
    assert rec.Say(t=1.0, text="point at the red robot") != rec.Press(t=1.0, name="point at the red robot")


@EXACT
@given(records())
def test_json_gives_back_the_same_record_to_the_last_bit(record):
    back = ANY.decode(msgspec.json.encode(record))
    assert back == record
    assert repr(back) == repr(record)  # tells -0.0 from 0.0, and 1 from 1.0


def test_json_as_it_stands_in_a_file():
    drive = rec.Drive(t=0.1 + 0.2, robot="cellulo_1", velocity=(0.05, -0.0), turn=1e-7, until=0.8)
    assert msgspec.json.encode(drive) == (
        b'{"type":"Drive","t":0.30000000000000004,"robot":"cellulo_1","velocity":[0.05,-0.0],"turn":1e-7,"until":0.8}'
    )


def test_whole_numbers_in_json_are_read_as_floats():
    hit = ANY.decode(b'{"type":"Tick","t":3}')
    assert hit == rec.Tick(t=3.0)
    assert isinstance(hit.t, float)


@pytest.mark.parametrize(
    "text",
    [
        b'{"type":"Wave","t":1.0}',
        b'{"type":"Tap","t":1.0}',
        b'{"type":"Tap","t":null,"source":"a"}',
        b'{"type":"Touch","t":1.0,"robot":"a","key":1,"kind":"licked"}',
        b'{"type":"Light","t":1.0,"robot":"a","colour":[1,2]}',
    ],
)
def test_json_that_is_no_record_is_refused(text):
    with pytest.raises(msgspec.ValidationError):
        ANY.decode(text)


@EXACT
@given(records(), st.sampled_from([math.nan, math.inf, -math.inf]), st.data())
def test_one_number_that_is_not_finite_is_found_wherever_it_is(record, bad, data):
    assert is_finite(record)
    path, _ = data.draw(st.sampled_from(list(leaves(record))))
    assert not is_finite(replaced(record, path, bad))


@pytest.mark.parametrize(
    ("record", "finite"),
    [
        (SAMPLE, True),
        (POINTED, True),
        (rec.Tick(t=math.nan), False),
        (msgspec.structs.replace(SAMPLE, acc=(0.0, math.inf, 0.0)), False),
        (msgspec.structs.replace(SAMPLE, quat=(math.nan, 0.0, 0.0, 0.0)), False),
        (msgspec.structs.replace(POINTED, covariance=((1.0, 0.0), (math.nan, 1.0))), False),
        (rec.Scores(t=0.0, source="a", labels=("nan",), probabilities=(1.0, -math.inf)), False),
        (rec.Say(t=0.0, text="nan"), True),
    ],
)
def test_finite_by_hand(record, finite):
    assert is_finite(record) is finite


def test_every_record_type_is_an_event_or_an_output_and_commands_are_outputs():
    defined = {kind for kind in vars(rec).values() if isinstance(kind, type) and issubclass(kind, Record)}
    assert {*EVENTS, *OUTPUTS} == defined - {Record}
    assert not {*EVENTS} & {*OUTPUTS}
    assert {*COMMANDS} < {*OUTPUTS}
    assert (set(get_args(rec.Event)), set(get_args(rec.Command))) == ({*EVENTS}, {*COMMANDS})
    assert set(get_args(rec.Output)) == {*OUTPUTS}
    assert set(get_args(rec.Model)) == set(rec.MODELS)


@pytest.mark.parametrize("kind", [rec.Body, rec.Zone, rec.Sheet])
def test_a_misspelt_setting_is_refused(kind):
    with pytest.raises(msgspec.ValidationError, match="eye_hight_m"):
        msgspec.json.decode(b'{"eye_hight_m":1.6}', type=kind)
