import numpy as np
import pytest

from armspan.devices.cellulo.relay import CONNECTED, client_side, server_side
from armspan.devices.cellulo.wire import COMMANDS, EVENTS

ASH, ELM = "00:06:66:E7:8A:D8", "00:06:66:74:40:E3"
AT_ASH, AT_ELM = "0140000666e78ad8", "01400006667440e3"
PING, CLEAR, ACK = (bytes.fromhex(text) for text in ("0150", "0158", "0141"))


def test_an_address_goes_before_a_packet_only_where_it_changes():
    host = client_side()
    told = [host.pack(mac, packet).hex() for mac, packet in [(ASH, PING), (ASH, CLEAR), (ELM, PING), (ASH, PING)]]
    assert told == [AT_ASH + "0150", "0158", AT_ELM + "0150", AT_ASH + "0150"]


def test_after_a_connection_status_the_address_is_told_again():
    host = client_side()
    assert host.pack(ASH, CLEAR).hex() == AT_ASH + "0158"
    assert host.status(ASH, CONNECTED).hex() == "0121" + "02000000000000"
    assert host.pack(ASH, PING).hex() == AT_ASH + "0150"
    assert host.status(ELM, CONNECTED, "A0:A4:C5:91:5E:9B").hex() == AT_ELM + "012102a0a4c5915e9b"


def test_each_direction_has_an_address_of_its_own():
    host, pool = client_side(), server_side()
    assert pool.feed(host.pack(ASH, PING), 0.0) == [(ASH, PING)]
    assert pool.pack(ELM, ACK).hex() == AT_ELM + "0141"
    assert host.feed(bytes.fromhex(AT_ELM + "0141" + "014f"), 0.0) == [(ELM, ACK), (ELM, bytes.fromhex("014f"))]
    assert host.pack(ASH, CLEAR) == CLEAR


def test_what_comes_before_any_address_is_dropped_except_a_heartbeat():
    pool = server_side()
    assert pool.feed(bytes.fromhex("0158" + "0126" + "012102000000000000"), 3.0) == []
    assert pool.heard == 3.0
    assert pool.feed(bytes.fromhex("0158" + AT_ASH + "0158"), 3.1) == [(ASH, CLEAR)]


def test_the_pool_forgets_the_address_after_a_status():
    pool = server_side()
    heard = pool.feed(bytes.fromhex(AT_ASH + "012102000000000000" + "0158" + AT_ASH + "0150"), 0.0)
    assert heard == [(ASH, bytes.fromhex("012102000000000000")), (ASH, PING)]


def test_local_adapters_are_no_robots():
    host = client_side()
    stream = "013e01a0a4c5915e9b" + AT_ASH + "013e00a0a4c5915e9b" + "0141"
    assert host.feed(bytes.fromhex(stream), 0.0) == [(ASH, ACK)]


def test_heartbeats_go_out_every_second_and_a_half():
    host = client_side(10.0)
    sent = [round(10 + 0.1 * k, 1) for k in range(50) if host.beat(10 + 0.1 * k) == bytes.fromhex("0126")]
    assert sent == pytest.approx([11.5, 13.0, 14.5], abs=0.11)


def test_silence_of_six_seconds_is_the_end():
    host = client_side(10.0)
    host.feed(bytes.fromhex("0126"), 12.0)
    host.feed(bytes.fromhex(AT_ASH + "0141"), 16.0)  # a packet is no heartbeat
    assert not host.silent(17.9)
    assert host.silent(18.0)


@pytest.mark.parametrize("seed", range(3))
def test_many_robots_over_one_stream_cut_anywhere(seed):
    rng = np.random.default_rng(seed)
    host, pool = client_side(), server_side()
    macs = [f"00:06:66:01:01:{k:02X}" for k in range(4)]
    names = ["ping", "clearTracking", "queryBatteryState", "reset"]
    sent = [(macs[rng.integers(4)], COMMANDS.encode(names[rng.integers(4)])) for _ in range(200)]
    stream = b"".join(host.pack(mac, packet) for mac, packet in sent)
    heard, at = [], 0
    while at < len(stream):
        step = int(rng.integers(1, 12))
        heard += pool.feed(stream[at : at + step], 0.0)
        at += step
    assert heard == sent


@pytest.mark.parametrize("side", [client_side, server_side])
def test_noise_raises_nothing(side):
    rng, stream = np.random.default_rng(0), side()
    for _ in range(300):
        noise = rng.integers(0, 256, size=50, dtype=np.uint8)
        noise[rng.random(50) < 0.2] = 1
        stream.feed(noise.tobytes(), 0.0)
    stream.feed(bytes(200), 0.0)
    packet = EVENTS.encode("acknowledged") if side is client_side else PING
    assert stream.feed(bytes.fromhex(AT_ASH) + packet, 0.0) == [(ASH, packet)]
