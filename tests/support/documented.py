"""What the documentation prints: commands, the output it claims for them, and Python.

A page is run from top to bottom in one folder, so that a command finds what the ones above it
wrote. HTML comments above a block, which readers do not see, say how:

``<!-- exit 1 -->``
    the exit code of every command in the block, if it is not 0;
``<!-- makes: FILE -->``, ``<!-- needs: FILE -->``
    a file that Python of one page makes and commands of any page use;
``<!-- slow -->``
    the block takes more than a few seconds;
``<!-- tested with: --days 1:365:91 -->``
    options that the test gives a coarser value, where a fine grid is for the eye alone;
``<!-- not run: REASON -->``
    the block is not run;
``<!-- printed: A; B -->``
    below a block: texts in the output of its commands. They are where numbers of the prose
    come from.
"""

import re
import shlex
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
# What the build of the site writes, pages that only the site has, and tables made by the software.
_NOT_READ = ("_build", "gallery", "generated", "development", "tables")
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted(p for p in DOCS.rglob("*.md") if not set(p.relative_to(DOCS).parts) & set(_NOT_READ)),
]

BOX_DRAWING = re.compile("[\u2500-\u257f]+")
# A rule of a table, as wide as what is in its column.
RULE = re.compile("([\u2500\u2501\u2550])\\1+")
TOKEN = re.compile(r"[-+−]?\d+(?:\.\d+)?|[^\W\d_]+|[^\s\w]|_")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?")
# What varies from run to run, or with the version of the solver: no page claims it.
VARIES = re.compile(r"\d ?(?:ms|iterations?)\b")
ELLIPSIS_LINE = "..."


def without_code(page):
    """Text of a page without its blocks."""
    return re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


@dataclass(frozen=True)
class Command:
    """One command line of a block, with what the page says that it prints."""

    text: str
    claimed: str | None = None

    def words(self):
        """Variables set in front, the words, and the file that standard output goes to."""
        words = shlex.split(self.text, comments=True)
        variables = {}
        while words and re.fullmatch(r"[A-Z_]+=\S*", words[0]):
            name, _, value = words.pop(0).partition("=")
            variables[name] = value
        target = None
        if len(words) > 2 and words[-2] == ">":
            target = words[-1]
            del words[-2:]
        return variables, words, target


@dataclass
class Block:
    """A fenced block of a page."""

    page: Path
    line: int
    language: str
    text: str
    exit_code: int = 0
    slow: bool = False
    tested_with: dict[str, str] = field(default_factory=dict)
    not_run: str | None = None
    makes: list[str] = field(default_factory=list)
    needs: list[str] = field(default_factory=list)
    printed: list[str] = field(default_factory=list)
    output: str | None = None

    def __str__(self):
        return f"{self.page.name}:{self.line}"

    @property
    def is_session(self):
        """Whether the block shows commands behind ``$``, each with its output below."""
        return self.language == "text" and self.text.startswith("$ ")

    def commands(self):
        """Commands of the block in order; none if it is neither a script nor a session."""
        if self.is_session:
            parts = re.split(r"^\$ ", self.text, flags=re.M)[1:]
            return [_with_output(part) for part in parts]
        if self.language != "sh":
            return []
        lines = self.text.replace("\\\n", " ").splitlines()
        found = [Command(line) for line in lines if shlex.split(line, comments=True)]
        if self.output is not None:
            found[-1] = Command(found[-1].text, self.output)
        return found


def _with_output(part):
    lines = part.splitlines()
    end = next(i for i, line in enumerate(lines) if not line.endswith("\\")) + 1
    text = " ".join(line.rstrip("\\") for line in lines[:end])
    return Command(text, "\n".join(lines[end:]))


def blocks(page):
    """All fenced blocks of a page, with what the comments around them say."""
    found = []
    comments = []
    between = []
    lines = iter(enumerate(page.read_text(encoding="utf-8").splitlines(), 1))
    for number, line in lines:
        if fence := re.fullmatch(r"```(\w*)", line):
            body = []
            for _, inner in lines:
                if inner == "```":
                    break
                body.append(inner)
            text = "\n".join(body)
            block = Block(page, number, fence[1], text)
            for comment in comments:
                _apply(block, comment)
            is_output = block.language == "text" and not block.is_session and not comments
            if is_output and not between and found and found[-1].language == "sh":
                found[-1].output = text
            found.append(block)
            comments, between = [], []
        elif comment := re.fullmatch(r"<!-- (.*) -->", line.strip()):
            if comment[1].startswith("printed: "):
                found[-1].printed += comment[1].removeprefix("printed: ").split("; ")
            else:
                comments.append(comment[1])
        elif line.strip():
            comments = []
            between.append(line)
    return found


def _apply(block, comment):
    if comment in ("main-command", "test-command"):
        block.not_run = "the continuous integration runs it as it stands, see .ci/run"
    name, _, value = comment.partition(" ")
    if name == "slow":
        block.slow = True
    elif name == "exit":
        block.exit_code = int(value)
    elif comment.startswith("tested with:"):
        words = shlex.split(comment.removeprefix("tested with:"))
        block.tested_with |= dict(zip(words[::2], words[1::2], strict=True))
    elif name in ("needs:", "makes:"):
        (block.needs if name == "needs:" else block.makes).append(value)
    elif comment.startswith("not run:"):
        block.not_run = comment.removeprefix("not run:").strip()


def replaced(words, options):
    """Words of a command with other values of some options, which it must have."""
    changed = list(words)
    for option, value in options.items():
        changed[changed.index(option) + 1] = value
    return changed


def tokens(text):
    """Words, numbers and signs of a text; rules of tables are equal, however wide."""
    return TOKEN.findall(RULE.sub(r"\1", text))


def _same(claimed, actual):
    if claimed == actual:
        return True
    a, b = claimed.replace("−", "-"), actual.replace("−", "-")
    if not (NUMBER.fullmatch(a) and NUMBER.fullmatch(b)):
        return False
    decimals = [len(number.partition(".")[2]) for number in (a, b)]
    # The last digit may be rounded the other way on another machine; counts may not.
    return decimals[0] == decimals[1] > 0 and abs(float(a) - float(b)) < 1.5 * 10.0 ** -decimals[0]


def _matching(claimed, actual):
    """Number of tokens at the start of a claim that agree with the start of the output."""
    for i, token in enumerate(claimed):
        if i >= len(actual) or not _same(token, actual[i]):
            return i
    return len(claimed)


def disagreement(claimed, actual):
    """First place where an output is not what a page claims, or ``None``.

    A line ``...`` of the claim stands for any lines.
    """
    parts = re.split(rf"^{re.escape(ELLIPSIS_LINE)}$", claimed, flags=re.M)
    rest = tokens(actual)
    for number, part in enumerate(parts):
        wanted = tokens(part)
        starts = range(len(rest) + 1) if number else range(1)
        matched, start = max(
            ((_matching(wanted, rest[start:]), -start) for start in starts), default=(0, 0)
        )
        if matched < len(wanted):
            shown = " ".join(wanted[max(0, matched - 8) : matched + 6])
            found = rest[-start : -start + matched + 6]
            return f"claimed: ... {shown} ...\n  printed: ... {' '.join(found[-14:])} ..."
        rest = rest[-start + matched :]
    if parts[-1].strip() and rest:
        return f"printed but not claimed: {' '.join(rest[:14])} ..."
    return None


def not_printed(block, printed):
    """Texts of the comments below a block that its commands do not print."""
    cells = BOX_DRAWING.sub(" ", printed)
    return [text for text in block.printed if disagreement(f"...\n{text}\n...", cells)]


def inline_commands(page):
    """Code in the text of a page that begins like a call of the command."""
    spans = re.findall(r"`([^`]+)`", without_code(page))
    return [" ".join(span.split()) for span in spans if span.startswith("solar-uav ")]


def inline_options(page):
    """Options that the text of a page names."""
    spans = re.findall(r"`([^`]+)`", without_code(page))
    return {option for span in spans for option in re.findall(r"(?<!\S)--[a-z][a-z-]*", span)}
