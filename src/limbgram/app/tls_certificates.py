"""TLS certificates: the certificate and key of the app on a network.

In      the address and names by which browsers reach this machine; or files of the clinic's own.
Out     a certificate and its key as files, and the fingerprint that browsers show.
Method  Self-signed, with an elliptic key (P-256), valid for 820 days, because some systems refuse
        longer ones. It is kept, and renewed a month before its end or when an address or name is
        missing in it. Browsers do not know it: compare the fingerprint once.
Fails   OptionsError: the given files are no certificate and key, do not match, or are out of date.
"""

import ipaddress
import ssl
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from limbgram.app.users import make_private
from limbgram.core.errors import OptionsError
from limbgram.core.files import read_content, written_whole

_GOOD = timedelta(days=820)
_RENEWED = timedelta(days=30)
_LARGEST_BYTES = 1_000_000


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """Files of a certificate and its key, and the fingerprint to compare in the browser."""

    file: Path
    key: Path
    fingerprint: str
    """SHA-256, as browsers show it."""
    ends: datetime


def own_certificate(folder: Path, names: Sequence[str]) -> Certificate:
    """The program's own certificate; made now if there is none that fits.

    Args:
        folder: SHELF/access.
        names: Addresses and names by which browsers reach this machine.
    """
    file, key = folder / "certificate.pem", folder / "key.pem"
    if file.is_file() and key.is_file():
        try:
            kept = given_certificate(file, key)
            lasting = kept.ends - datetime.now(UTC) > _RENEWED
            if lasting and set(names) <= _names_in(_certificate(file)):
                return kept
        except OptionsError:
            pass  # damaged or over: another is made
    make_private(folder)
    _make(file, key, names)
    return given_certificate(file, key)


def given_certificate(file: Path, key: Path) -> Certificate:
    """A certificate of the clinic's own.

    Raises:
        OptionsError: it cannot be used; says why.
    """
    found = _certificate(file)
    now = datetime.now(UTC)
    if not found.not_valid_before_utc <= now <= found.not_valid_after_utc:
        raise OptionsError(
            "app.tls.not_now",
            file=str(file),
            begins=f"{found.not_valid_before_utc:%Y-%m-%d}",
            ends=f"{found.not_valid_after_utc:%Y-%m-%d}",
        )
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(file, key, password=_no_password(key))
    except (OSError, ValueError) as error:  # ssl.SSLError is an OSError
        raise OptionsError("app.tls.key_unfit", key=str(key), file=str(file)) from error
    digest = found.fingerprint(hashes.SHA256()).hex(":").upper()
    return Certificate(file=file, key=key, fingerprint=digest, ends=found.not_valid_after_utc)


def _no_password(key: Path) -> "bytes":
    """Refuse an encrypted key: nobody is there to type its password when the app starts."""
    if b"ENCRYPTED" in read_content(key, _LARGEST_BYTES, OptionsError, "Give a PEM file."):
        raise OptionsError("app.tls.key_locked", key=str(key))
    return b""


def _certificate(file: Path) -> x509.Certificate:
    content = read_content(file, _LARGEST_BYTES, OptionsError, "Give a PEM file.")
    try:
        return x509.load_pem_x509_certificate(content)
    except ValueError as error:
        raise OptionsError("app.tls.no_certificate", file=str(file)) from error


def _names_in(certificate: x509.Certificate) -> set[str]:
    try:
        said = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except x509.ExtensionNotFound:
        return set()
    hosts = said.get_values_for_type(x509.DNSName)
    return {*hosts, *(str(one) for one in said.get_values_for_type(x509.IPAddress))}


def _make(file: Path, key_file: Path, names: Sequence[str]) -> None:
    key = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "limbgram of this clinic")])
    now = datetime.now(UTC)
    made = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(hours=1))
        .not_valid_after(now + _GOOD)
        .add_extension(x509.SubjectAlternativeName([_as_name(one) for one in names]), False)
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), False)
        .sign(key, hashes.SHA256())
    )
    private = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    with written_whole(key_file) as beside:
        beside.touch(mode=0o600)
        beside.write_bytes(private)
    with written_whole(file) as beside:
        beside.write_bytes(made.public_bytes(serialization.Encoding.PEM))


def _as_name(name: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)
