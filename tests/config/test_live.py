import fast_time
from armspan.config.live import PATIENCE, Lead, led
from armspan.records import ImuSample, Press, Say, Tick

REST = ImuSample(0.1, "wrist", (0.0, 0.0, 9.8), (0.0, 0.0, 0.0))


def play(scene_of, bands=("wrist",), seconds=None):
    async def scene():
        began = fast_time.now()
        lead = Lead(lambda: fast_time.now() - began, bands, seconds)
        told = []
        async for event in lead.source():
            told.append(event)
            scene_of(lead, event)
        return told

    return fast_time.run(scene, 60.0)


def presses(told):
    return [(event.name, event.value) for event in told if isinstance(event, Press)]


def test_the_set_up_begins_once_every_band_was_heard():
    told = play(lambda lead, event: lead.hear(REST) if event.t > 1.0 else None, seconds=2.0)
    (setup,) = [event for event in told if isinstance(event, Press)]
    assert 1.0 < setup.t < 1.2
    assert 38 <= sum(isinstance(event, Tick) for event in told) <= 42


def test_a_band_that_is_never_heard_is_waited_for_so_long_only():
    (setup,) = [event for event in play(lambda *_: None, seconds=PATIENCE + 1) if isinstance(event, Press)]
    assert PATIENCE <= setup.t < PATIENCE + 0.2


def test_what_is_pressed_comes_at_the_next_tick_and_quit_ends():
    def scene(lead, event):
        if isinstance(event, Press) and event.name == "setup":
            lead.press("behaviour", "sweep")
        if event.t > 1.0:
            lead.press("quit")

    told = play(scene, bands=())
    assert presses(told) == [("setup", ""), ("behaviour", "sweep")]
    assert told[-1].t < 1.3


def test_it_ends_when_a_recording_is_done():
    told = play(lambda lead, event: lead.hear(Say(event.t, "Done", "done")) if event.t > 0.5 else None)
    assert told[-1].t < 0.7


def test_sources_beside_devices_lose_their_ticks_and_presses():
    async def source():
        for event in (Tick(0.0), REST, Press(0.2, "setup")):
            yield event

    async def scene():
        return [event async for event in led(source())]

    assert fast_time.run(scene) == [REST]
