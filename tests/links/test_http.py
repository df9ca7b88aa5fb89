import asyncio
import datetime
import ipaddress
import ssl
import stat

import pytest
from cryptography import x509

from armspan.errors import ConfigError, DeviceError
from armspan.links import certificate
from armspan.links.certificate import FILE, machine_names, server_tls
from armspan.links.http import Guard, host_and_port, is_loopback, posting, serving
from fast_time import run

TOKEN = "quiet-river-9"


async def answer(port, text, tls=None):
    """What a door answers to bytes, status and body."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=tls)
    writer.write(text if isinstance(text, bytes) else text.encode())
    data = await reader.read()
    writer.close()
    head, _, body = data.partition(b"\r\n\r\n")
    return (int(head.split()[1]) if head else 0), body.decode()


def request(path="/", body="", host="127.0.0.1:1", method="POST", **headers):
    lines = [f"{method} {path} HTTP/1.1", f"Host: {host}", f"Content-Length: {len(body)}", "Connection: close"]
    lines += [f"{name}: {value}" for name, value in headers.items()]
    return "\r\n".join(lines) + "\r\n\r\n" + body


def heard(guard, *requests, take=None, **options):
    """What a door with this guard answers to requests, and what it took."""
    taken = []

    async def scene():
        async with serving([posting("/", take or taken.append)], "127.0.0.1", 0, guard, **options) as port:
            return [await answer(port, text) for text in requests]

    return run(scene), taken


@pytest.mark.parametrize("host", ["127.0.0.1", "127.8.9.1", "::1", "[::1]", "localhost", "LOCALHOST"])
def test_this_machine_alone_needs_no_guard(host):
    assert is_loopback(host)
    Guard().check(host)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.4", "example.org", "", "127.0.0.1.example.org"])
def test_others_are_let_in_only_with_a_token_or_their_addresses(host):
    with pytest.raises(ConfigError, match=r"anybody on the network.*token = '.{8,}'.*allow = \["):
        Guard().check(host)
    Guard(TOKEN).check(host)
    Guard(allow=["192.168.1.9"]).check(host)


@pytest.mark.parametrize(
    "token", ["", "short", "with space in it", "ünïcödé-token", "a" * 65, "semi;colon", "a/b/c/d/e"]
)
def test_a_token_must_stand_in_a_url(token):
    with pytest.raises(ConfigError, match="8 to 64 letters"):
        Guard(token)


@pytest.mark.parametrize("address", ["192.168.1", "phone", "300.1.1.1", "192.168.1.0/33", ""])
def test_what_is_no_address_cannot_be_allowed(address):
    with pytest.raises(ConfigError, match="address such as"):
        Guard(allow=[address])


def test_a_token_is_asked_for_in_either_place():
    guard = Guard(TOKEN)
    answers, taken = heard(
        guard,
        request(f"/?token={TOKEN}", "one"),
        request(body="two", Authorization=f"Bearer {TOKEN}"),
        request(body="three", Authorization=TOKEN),
        request(body="four"),
        request(f"/?token={TOKEN}x", "five"),
        request(body="six", Authorization="Bearer "),
        request("/?token=%ff%fe%ed", "seven"),
    )
    assert [status for status, _ in answers] == [200, 200, 200, 403, 403, 403, 403]
    assert taken == [b"one", b"two", b"three"]
    assert guard.refused == 4
    assert "token" in answers[3][1]


def test_only_the_listed_addresses_come_in():
    guard = Guard(allow=["127.0.0.0/8"])
    assert heard(guard, request(body="a"))[0][0][0] == 200
    guard = Guard(allow=["192.168.1.9", "fe80::/10"])
    assert heard(guard, request(body="a"))[0][0][0] == 403
    assert guard.refused == 1
    assert guard.admits("192.168.1.9", None, "x")
    assert guard.admits("::ffff:192.168.1.9", None, "x")
    assert guard.admits("fe80::1%wlan0", None, "x")
    assert not guard.admits("192.168.1.10", None, "x")
    assert not guard.admits(None, None, "x")


def test_token_and_address_are_both_needed_where_both_are_set():
    guard = Guard(TOKEN, ["192.168.1.9"])
    assert guard.admits("192.168.1.9", TOKEN, "x")
    assert not guard.admits("192.168.1.9", None, "x")
    assert not guard.admits("192.168.1.10", TOKEN, "x")


def test_pages_of_others_cannot_use_a_door_of_this_machine():
    guard = Guard()
    answers, taken = heard(
        guard,
        request(body="own", host="127.0.0.1:8080", Origin="http://127.0.0.1:8080"),
        request(body="lured", host="127.0.0.1:8080", Origin="https://example.org"),
        request(body="null", host="127.0.0.1:8080", Origin="null"),
        request(body="rebound", host="example.org:8080"),
        request(body="localhost", host="localhost:8080"),
        request(body="bracket", host="[::1]:8080"),
    )
    assert [status for status, _ in answers] == [200, 403, 403, 403, 200, 200]
    assert taken == [b"own", b"localhost", b"bracket"]
    assert guard.refused == 3


def test_a_large_body_is_refused_and_the_next_is_heard():
    guard = Guard()
    answers, taken = heard(guard, request(body="x" * 101), request(body="y" * 100), largest=100)
    assert [status for status, _ in answers] == [413, 200]
    assert taken == [b"y" * 100]
    assert guard.too_large == 1


def test_what_cannot_be_read_is_answered_with_its_sentence():
    def take(data):
        if data == b"bad":
            raise DeviceError("this is bad; expected good")

    guard = Guard()
    answers, _ = heard(guard, request(body="bad"), request(body="good"), take=take)
    assert answers == [(400, "this is bad; expected good\n"), (200, "ok\n")]
    assert guard.malformed == 1


def test_noise_on_the_line_says_nothing_on_the_terminal(capfd):
    guard = Guard()
    noise = [
        b"\x00\xff\xfe\r\n\r\n",
        b"GET\r\n\r\n",
        b"POST / HTTP/1.1\r\nContent-Length: -5\r\n\r\n",
        b"\x16\x03\x01\r\n\r\n",
    ]
    answers, taken = heard(guard, *noise, request(body="after"))
    assert all(400 <= status < 500 or status == 0 for status, _ in answers[:-1])
    assert answers[-1][0] == 200
    assert taken == [b"after"]
    assert capfd.readouterr() == ("", "")


def test_other_paths_and_methods_are_answered():
    answers, _ = heard(Guard(), request("/else"), request(method="GET"))
    assert [status for status, _ in answers] == [404, 405]


def test_a_port_in_use_is_one_sentence():
    async def scene():
        async with serving([], "127.0.0.1", 0, Guard()) as port:
            with pytest.raises(
                DeviceError, match=rf"port {port} of 127\.0\.0\.1 is taken by another program; .*another port"
            ):
                async with serving([], "127.0.0.1", port, Guard()):
                    pass
            return port

    port = run(scene)

    async def again():
        async with serving([], "127.0.0.1", port, Guard()) as at:
            return at

    assert run(again) == port  # it was given back


def test_an_address_of_another_machine_cannot_be_listened_on():
    async def scene():
        async with serving([], "192.0.2.7", 8080, Guard(TOKEN)):
            pass

    with pytest.raises(DeviceError, match="no address of this machine"):
        run(scene)


def test_a_door_without_guard_does_not_open():
    async def scene():
        async with serving([], "0.0.0.0", 0, Guard()):
            pass

    with pytest.raises(ConfigError, match="anybody"):
        run(scene)


@pytest.mark.parametrize(
    ("text", "halves"),
    [("127.0.0.1:8443", ("127.0.0.1", 8443)), ("[::1]:80", ("::1", 80)), ("lab-pc:0", ("lab-pc", 0))],
)
def test_host_and_port(text, halves):
    assert host_and_port(text) == halves


@pytest.mark.parametrize(
    "text", ["", "8443", ":8443", "a:", "a:b", "a:70000", "::1:80", "a:-1", "[::1]", "[a]:80", "a:²"]
)
def test_what_is_no_host_and_port(text):
    with pytest.raises(ConfigError, match="HOST:PORT"):
        host_and_port(text)


# --- the certificate ---------------------------------------------------------------------------------------


NAMES = ("192.168.7.7", "127.0.0.1", "::1", "localhost")


def read(folder):
    return x509.load_pem_x509_certificate((folder / FILE).read_bytes())


def test_the_certificate_names_this_machine_and_is_the_owners(tmp_path):
    server_tls(tmp_path / "new" / "folder", NAMES)
    path = tmp_path / "new" / "folder" / FILE
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    found = read(path.parent)
    names = found.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert {str(ip) for ip in names.get_values_for_type(x509.IPAddress)} == {"192.168.7.7", "127.0.0.1", "::1"}
    assert names.get_values_for_type(x509.DNSName) == ["localhost"]
    life = found.not_valid_after_utc - found.not_valid_before_utc
    assert datetime.timedelta(days=396) < life <= datetime.timedelta(days=398)


def test_the_certificate_is_kept_until_it_ends(tmp_path, monkeypatch):
    server_tls(tmp_path, NAMES)
    first = (tmp_path / FILE).read_bytes()
    server_tls(tmp_path, NAMES[1:])
    assert (tmp_path / FILE).read_bytes() == first
    monkeypatch.setattr(certificate, "_SPARE", datetime.timedelta(days=398))
    server_tls(tmp_path, NAMES)
    assert (tmp_path / FILE).read_bytes() != first


def test_a_certificate_that_does_not_serve_is_made_anew(tmp_path):
    path = tmp_path / FILE
    server_tls(tmp_path, NAMES)
    first = path.read_bytes()
    server_tls(tmp_path, (*NAMES, "10.0.0.9"))  # another network
    second = path.read_bytes()
    assert second != first
    path.chmod(0o644)  # others may have read the key
    server_tls(tmp_path, NAMES)
    assert path.read_bytes() != second
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    key, _, _ = first.partition(b"-----BEGIN CERTIFICATE")
    for broken in (b"", b"nonsense", path.read_bytes()[:300], key + path.read_bytes().partition(b"\n-----BEGIN C")[2]):
        path.write_bytes(broken)
        server_tls(tmp_path, NAMES)
        assert set(NAMES[:3]) <= {
            str(ip)
            for ip in read(tmp_path)
            .extensions.get_extension_for_class(x509.SubjectAlternativeName)
            .value.get_values_for_type(x509.IPAddress)
        }


def test_a_folder_that_cannot_be_written_to_is_one_sentence(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(ConfigError, match=r"cannot be kept in .*choose a folder"):
        server_tls(tmp_path / "file", NAMES)


def test_a_client_that_knows_the_certificate_is_content(tmp_path):
    tls = server_tls(tmp_path, NAMES)
    knows = ssl.create_default_context(cadata=read(tmp_path).public_bytes(certificate_encoding()).decode())
    taken = []

    async def scene():
        async with serving([posting("/", taken.append)], "127.0.0.1", 0, Guard(), tls) as port:
            return await answer(port, request(body="sealed"), knows)

    assert run(scene) == (200, "ok\n")
    assert taken == [b"sealed"]


def certificate_encoding():
    from cryptography.hazmat.primitives.serialization import Encoding

    return Encoding.PEM


def test_this_machine_knows_its_names():
    names = machine_names()
    assert {"127.0.0.1", "::1", "localhost"} <= set(names)
    assert len(names) == len(set(names))
    addresses = [name for name in names if name.replace(".", "").isdigit()]
    assert all(ipaddress.ip_address(name) for name in addresses)
