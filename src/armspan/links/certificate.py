"""A certificate of this machine's own making, so that a phone's browser lets a page use its sensors.

Nobody vouches for it: the browser warns once, and the person who knows whose it is goes on.
"""

import datetime
import ipaddress
import os
import socket
import ssl
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from armspan.errors import ConfigError, MissingExtra

if TYPE_CHECKING:
    from cryptography import x509

FILE = "armspan-door.pem"
DAYS = 397
"""The longest that phones suffer (Apple, 'About upcoming limits on trusted certificates', 2020)."""
_SPARE = datetime.timedelta(days=1)


def machine_names() -> tuple[str, ...]:
    """Names and addresses by which other devices may know this machine, the most likely address first."""
    names = [address for kind in (socket.AF_INET, socket.AF_INET6) if (address := _outward(kind))]
    with suppress(OSError):
        for found in socket.getaddrinfo(socket.gethostname(), None):
            names.append(str(found[4][0]).partition("%")[0])
    return tuple(dict.fromkeys([*names, "127.0.0.1", "::1", "localhost", socket.gethostname()]))


def _outward(family: socket.AddressFamily) -> str | None:
    """The address from which this machine would speak to others; nothing is sent."""
    with suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as probe:
        probe.connect(("192.0.2.1" if family == socket.AF_INET else "2001:db8::1", 9))
        return str(probe.getsockname()[0])
    return None


def server_tls(folder: Path, names: tuple[str, ...] | None = None) -> ssl.SSLContext:
    """A server's side of TLS with the certificate kept in ``folder``.

    It is made where there is none, where it ends within a day, and where it does not name this machine's present
    ``names``. The file holds the key and may be read by its owner only.

    Raises:
        ConfigError: where the folder cannot be written to.
        MissingExtra: without cryptography.

    """
    wanted = machine_names() if names is None else names
    path = folder / FILE
    if not _serves(path, wanted):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            _write(path, _made(wanted))
        except OSError as error:
            raise ConfigError(
                f"the certificate cannot be kept in {folder}: {error.strerror}; choose a folder that can be written to"
            ) from None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(path)
    return context


def _write(path: Path, pem: bytes) -> None:
    """Write for the owner's eyes only, from the first byte on, and all at once."""
    fresh = path.with_suffix(".new")
    fresh.unlink(missing_ok=True)
    with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "wb") as file:
        file.write(pem)
    fresh.replace(path)


def _serves(path: Path, names: tuple[str, ...]) -> bool:
    try:
        from cryptography import x509
        from cryptography.hazmat.primitives.serialization import load_pem_private_key
    except ImportError:
        raise MissingExtra("cryptography", "phone") from None
    try:
        pem = path.read_bytes()
        found = x509.load_pem_x509_certificate(pem)
        same = load_pem_private_key(pem, None).public_key() == found.public_key()
        told = found.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (OSError, ValueError, TypeError, x509.ExtensionNotFound):
        return False
    if path.stat().st_mode & 0o077:
        return False  # others may have read the key
    now = datetime.datetime.now(datetime.UTC)
    known = {str(value) for kind in (x509.DNSName, x509.IPAddress) for value in told.get_values_for_type(kind)}
    return same and found.not_valid_before_utc <= now < found.not_valid_after_utc - _SPARE and set(names) <= known


def _made(names: tuple[str, ...]) -> bytes:
    """A key and its certificate, as PEM."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "Armspan on this machine")])
    now = datetime.datetime.now(datetime.UTC)
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(hours=1))  # a phone's clock may be behind
        .not_valid_after(now + datetime.timedelta(days=DAYS, hours=-1))
        .add_extension(x509.SubjectAlternativeName([_general(text) for text in names]), critical=False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), critical=True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), critical=False)
        .sign(key, hashes.SHA256())
    )
    secret = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    return secret + made.public_bytes(serialization.Encoding.PEM)


def _general(text: str) -> "x509.GeneralName":
    from cryptography import x509

    try:
        return x509.IPAddress(ipaddress.ip_address(text))
    except ValueError:
        return x509.DNSName(text)
