"""Templates: rectifications that a clinic learned from its own cases, kept on the shelf.

SHELF/templates/ID.json   a template's file, as `limbgram template learn` writes it
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from limbgram.cases.shelf_ids import LONGEST_NAME, is_id, new_id
from limbgram.core.errors import MissingError, OptionsError, ShapeFileError, printable
from limbgram.core.files import write_bytes
from limbgram.workbench.templates.files import decode_template, encode_template, read_template
from limbgram.workbench.templates.learning import Learned, Pair, learn
from limbgram.workbench.templates.template import Template


@dataclass(frozen=True)
class KeptTemplate:
    """One template on the shelf."""

    template_id: str
    file: Path

    def read(self) -> Template:
        """The template.

        Raises:
            ShapeFileError: its file is damaged.
        """
        return read_template(self.file)


@dataclass(frozen=True)
class Templates:
    """The templates of a shelf."""

    root: Path

    def all(self) -> tuple[KeptTemplate, ...]:
        if not self.root.is_dir():
            return ()
        files = sorted(self.root.glob("*.json"))
        return tuple(KeptTemplate(one.stem, one) for one in files if is_id(one.stem))

    def template(self, template_id: str) -> KeptTemplate:
        """One template.

        Raises:
            LookupError: there is none of that id.
        """
        file = self.root / f"{template_id}.json"
        if not is_id(template_id) or not file.is_file():
            raise MissingError("case.template.none")
        return KeptTemplate(template_id, file)

    def learn(self, name: str, pairs: Sequence[Pair]) -> Learned:
        """Learn a template and keep it; the notes say how far to trust it.

        Raises:
            OptionsError: a name that cannot be shown, or sides mixed.
            MeasureError: a pair without axes or shared landmarks, or nothing to learn.
        """
        plain = name.strip()
        if not 0 < len(plain) <= LONGEST_NAME or printable(plain, keep="") != plain:
            raise OptionsError("case.template.name_length", most=LONGEST_NAME)
        learned = learn(pairs, plain)
        self._keep(encode_template(learned.template))
        return learned

    def take(self, content: bytes) -> None:
        """Keep a template's file that was made elsewhere.

        Raises:
            ShapeFileError: it is none.
        """
        try:
            decode_template(content)
        except ValueError as error:
            raise ShapeFileError("case.template.unreadable", why=str(error)) from error
        self._keep(content)

    def remove(self, template: KeptTemplate) -> None:
        """Delete a template; recipes keep what they took of it."""
        template.file.unlink()

    def _keep(self, content: bytes) -> None:
        self.root.mkdir(parents=True, exist_ok=True)
        made = new_id()
        write_bytes(self.root / f"{made}.json", content)
