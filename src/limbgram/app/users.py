"""Users: who may sign in on a network, by name and password.

In      names and passwords, given on the clinic's machine itself (`limbgram app users`).
Out     whether a password is right; a stamp that changes with the password.
Method  SHELF/access/users.json keeps an argon2id hash of each password (RFC 9106, its second
        recommended choice: 64 MiB, 3 passes), never the password. The file is read again when it
        changes, so that a removed user is signed out at once. One password is verified at a time:
        it takes 64 MiB, and many guesses must not exhaust the memory.
Fails   OptionsError: a name or a password that cannot be used. CaseError: the file is damaged.
"""

import hashlib
import re
import threading
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError

from limbgram.cases.case_record import utc_now, write_json
from limbgram.core.errors import CaseError, OptionsError, printable
from limbgram.core.files import json_of, read_content
from limbgram.core.typed import TOLERANT, Mismatch, tree_of, value_of

ACCESS_FOLDER = "access"
"""On the shelf: users, the log, the certificate; for the owner of the program alone."""
LEAST_LETTERS = 12
"""NIST SP 800-63B asks for 8 where there is a second factor; here is none, and no rule on signs."""
MOST_LETTERS = 200
_NAME = re.compile(r"[^\W_][\w .'@-]{0,39}")
_LARGEST_BYTES = 1_000_000
_SCHEMA = "limbgram-users/1"


@dataclass(frozen=True, kw_only=True)
class User:
    """Somebody who may sign in."""

    name: str
    password: str
    """Its argon2id hash."""
    made: str
    """Date and time, UTC, of the password."""


@dataclass(frozen=True, kw_only=True)
class _File:
    users: tuple[User, ...] = ()
    schema: str = _SCHEMA


@dataclass
class Users:
    """The users of a shelf."""

    folder: Path
    """SHELF/access."""
    hasher: PasswordHasher = field(default_factory=PasswordHasher)
    _read: tuple[tuple[int, int, int], tuple[User, ...]] | None = None
    _one_at_a_time: threading.Lock = field(default_factory=threading.Lock)

    @property
    def file(self) -> Path:
        return self.folder / "users.json"

    def all(self) -> tuple[User, ...]:
        """All users, by name.

        Raises:
            CaseError: the file is there and cannot be read.
        """
        try:
            status = self.file.stat()
        except FileNotFoundError:
            return ()
        key = status.st_mtime_ns, status.st_size, status.st_ino
        known = self._read
        if known is None or known[0] != key:
            known = self._read = key, self._from_disk()
        return known[1]

    def named(self, name: str) -> User | None:
        """The user of a name, whatever the case of its letters; None if there is none."""
        wanted = _folded(name)
        return next((one for one in self.all() if _folded(one.name) == wanted), None)

    def stamp(self, name: str) -> str:
        """A stamp that changes with the password; empty if the name is unknown."""
        found = self.named(name)
        return "" if found is None else hashlib.sha256(found.password.encode()).hexdigest()

    def known_as(self, name: str) -> str:
        """The user's name as registered, whatever the case of its letters; empty if unknown."""
        found = self.named(name)
        return "" if found is None else found.name

    def is_right(self, name: str, password: str) -> bool:
        """Whether a password is right; takes as long for an unknown name."""
        found = self.named(name)
        kept = self._hash_for_unknown if found is None else found.password
        with self._one_at_a_time:
            try:
                right = self.hasher.verify(kept, _normal(password[:MOST_LETTERS]))
            except (VerificationError, InvalidHashError):
                right = False
        return right and found is not None

    def add(self, name: str, password: str) -> User:
        """Let somebody sign in.

        Raises:
            OptionsError: the name is taken or none, or the password too short or easily guessed.
        """
        return self._keep(self.require_new(name), password)

    def change(self, name: str, password: str) -> User:
        """Give a user another password; they are signed out everywhere.

        Raises:
            OptionsError: there is no such user, or the password cannot be used.
        """
        return self._keep(self.require(name).name, password)

    def remove(self, name: str) -> User:
        """Let somebody sign in no more; they are signed out everywhere.

        Raises:
            OptionsError: there is no such user.
        """
        gone = self.require(name)
        self._write([one for one in self.all() if one != gone])
        return gone

    def require(self, name: str) -> User:
        """The user of a name.

        Raises:
            OptionsError: there is none.
        """
        found = self.named(name)
        if found is None:
            known = tuple(one.name for one in self.all())
            raise OptionsError(
                "app.user.none", name=printable(name, keep="")[:40], users=known or None
            )
        return found

    def require_new(self, name: str) -> str:
        """A name that nobody has yet.

        Raises:
            OptionsError: somebody has it, or it is none.
        """
        name = checked_user_name(name)
        if self.named(name) is not None:
            raise OptionsError("app.user.known", name=name)
        return name

    def _keep(self, name: str, password: str) -> User:
        password = _checked_password(name, password)
        kept = User(name=name, password=self.hasher.hash(password), made=utc_now())
        self._write([*(one for one in self.all() if _folded(one.name) != _folded(name)), kept])
        return kept

    def _write(self, users: Sequence[User]) -> None:
        make_private(self.folder)
        kept = _File(users=tuple(sorted(users, key=lambda one: _folded(one.name))))
        write_json(self.file, tree_of(kept))
        self.file.chmod(0o600)

    def _from_disk(self) -> tuple[User, ...]:
        try:
            tree = json_of(read_content(self.file, _LARGEST_BYTES, CaseError))
            return value_of(tree, _File, strictness=TOLERANT).users
        except (Mismatch, ValueError) as error:
            raise CaseError("app.user.list_damaged", file=str(self.file), why=str(error)) from error

    @cached_property
    def _hash_for_unknown(self) -> str:
        """A hash to verify against for unknown names, so that the answer takes as long."""
        return self.hasher.hash("nobody has this password")


def make_private(folder: Path) -> Path:
    """Make a folder that only its owner can open, on systems with owners."""
    folder.mkdir(parents=True, exist_ok=True)
    folder.chmod(0o700)
    return folder


def checked_user_name(name: str) -> str:
    """A name by which somebody can sign in.

    Raises:
        OptionsError: it is none.
    """
    normal = _normal(name).strip()
    if not _NAME.fullmatch(normal):
        raise OptionsError("app.user.no_name", name=printable(name, keep="")[:60])
    return normal


def _checked_password(name: str, password: str) -> str:
    normal = _normal(password)
    if not LEAST_LETTERS <= len(normal) <= MOST_LETTERS:
        raise OptionsError(
            "app.user.password_length", letters=len(normal), least=LEAST_LETTERS, most=MOST_LETTERS
        )
    if len(set(normal)) < 5 or _folded(name) in _folded(normal):
        raise OptionsError("app.user.password_weak")
    return normal


def _normal(text: str) -> str:
    """The text in NFC: keyboards encode the same letter in different ways."""
    return unicodedata.normalize("NFC", text)


def same_name(one: str, other: str) -> bool:
    """Whether two names are one user's: capitals do not tell users apart."""
    return _folded(one) == _folded(other)


def _folded(name: str) -> str:
    return _normal(name).strip().casefold()
