"""Users: who may sign in on a network, by name and password.

In      names and passwords, given on the clinic's machine itself (`limbgram app users`).
Out     whether a password is right; a stamp that is another one after the password was changed.
Method  SHELF/access/users.json keeps each password as argon2id makes it (RFC 9106, its second
        recommended choice: 64 MiB, 3 passes), never the password. The file is read again when it
        changed, so that a user who was removed is out at once. One password is tried at a time: it
        takes 64 MiB, and guesses in numbers must not take the memory of the machine.
Fails   OptionsError: a name or a password that cannot be used. CaseError: the file is damaged.
"""

import hashlib
import re
import threading
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from functools import cached_property
from pathlib import Path

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError

from limbgram.cases.case_record import write_json
from limbgram.core.errors import CaseError, OptionsError, printable
from limbgram.core.files import json_of, read_content
from limbgram.core.typed import Mismatch, Strictness, tree_of, value_of

ACCESS_FOLDER = "access"
"""On the shelf: users, the log, the certificate; for the owner of the program alone."""
LEAST_LETTERS = 12
"""NIST SP 800-63B asks for 8 where there is a second factor; here is none, and no rule on signs."""
MOST_LETTERS = 200
_NAME = re.compile(r"[^\W_][\w .'@-]{0,39}")
_LARGEST = 1_000_000
_SCHEMA = "limbgram-users/1"
_AS_WRITTEN = Strictness(pass_over_unknown=True)


@dataclass(frozen=True, kw_only=True)
class User:
    """Somebody who may sign in."""

    name: str
    password: str
    """As argon2id made it."""
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
        """The user of a name; capitals do not matter."""
        wanted = _folded(name)
        return next((one for one in self.all() if _folded(one.name) == wanted), None)

    def stamp(self, name: str) -> str:
        """Another one after the password was changed; empty where nobody has the name."""
        found = self.named(name)
        return "" if found is None else hashlib.sha256(found.password.encode()).hexdigest()

    def known_as(self, name: str) -> str:
        """The name as it was given here, whatever its capitals; empty where nobody has it."""
        found = self.named(name)
        return "" if found is None else found.name

    def is_right(self, name: str, password: str) -> bool:
        """Whether a password is that of a name; takes as long where nobody has the name."""
        found = self.named(name)
        kept = self._nobodys if found is None else found.password
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
        now = datetime.now(UTC).isoformat(timespec="seconds")
        kept = User(name=name, password=self.hasher.hash(password), made=now)
        self._write([*(one for one in self.all() if _folded(one.name) != _folded(name)), kept])
        return kept

    def _write(self, users: Sequence[User]) -> None:
        made_private(self.folder)
        kept = _File(users=tuple(sorted(users, key=lambda one: _folded(one.name))))
        write_json(self.file, tree_of(kept))
        self.file.chmod(0o600)

    def _from_disk(self) -> tuple[User, ...]:
        try:
            tree = json_of(read_content(self.file, _LARGEST, CaseError))
            return value_of(tree, _File, strictness=_AS_WRITTEN).users
        except (Mismatch, ValueError) as error:
            raise CaseError("app.user.list_damaged", file=str(self.file), why=str(error)) from error

    @cached_property
    def _nobodys(self) -> str:
        """What is tried where nobody has the name: it takes as long, and nothing fits it."""
        return self.hasher.hash("nobody has this password")


def made_private(folder: Path) -> Path:
    """A folder that only the owner of the program can open, on systems that know owners."""
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
    """Keyboards write the same letter in different ways."""
    return unicodedata.normalize("NFC", text)


def _folded(name: str) -> str:
    return _normal(name).strip().casefold()
