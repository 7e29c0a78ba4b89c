"""Result files, written completely or not at all, and YAML that reads back equal."""

from __future__ import annotations

import json
import os
import stat
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, ClassVar

import yaml

from missions.files.errors import printable
from missions.files.yaml import add_resolvers
from solar.versions import FORMAT_KEY, FORMAT_VERSION


class OutputError(OSError):
    """A file cannot be written; the text names it and the reason."""


_NUMBERED = [f"{port}{number}" for port in ("COM", "LPT") for number in range(10)]
_DEVICES = frozenset({"CON", "PRN", "AUX", "NUL", *_NUMBERED})
# Characters of a mapping or list that is written on one line.
_SHORT = 84
_REPRESENTERS: Any = yaml.SafeDumper.yaml_representers


class _Dumper(yaml.SafeDumper):
    """YAML dumper that quotes text which would not read back as text."""

    # The key None is of whatever else there is: it is refused.
    yaml_representers: ClassVar[Any] = {
        kind: _REPRESENTERS[kind] for kind in (type(None), bool, list, tuple, dict, None)
    }

    def ignore_aliases(self, data: Any) -> bool:
        return True


class _CompactDumper(_Dumper):
    """YAML dumper that writes short innermost mappings and lists on one line."""

    def represent_mapping(self, *args: Any, **kwargs: Any) -> yaml.MappingNode:
        node = super().represent_mapping(*args, **kwargs)
        _fit_on_line(node, [part for pair in node.value for part in pair])
        return node

    def represent_sequence(self, *args: Any, **kwargs: Any) -> yaml.SequenceNode:
        node = super().represent_sequence(*args, **kwargs)
        _fit_on_line(node, node.value)
        return node


def _fit_on_line(node: yaml.CollectionNode, parts: list[yaml.Node]) -> None:
    if all(isinstance(part, yaml.ScalarNode) for part in parts):
        node.flow_style = sum(len(str(part.value)) + 2 for part in parts) <= _SHORT


# With their subclasses, as numpy's and enumerations are.
_Dumper.add_multi_representer(int, lambda dumper, value: dumper.represent_int(int(value)))
_Dumper.add_multi_representer(float, lambda dumper, value: dumper.represent_float(float(value)))
_Dumper.add_multi_representer(
    str,
    lambda dumper, text: dumper.represent_scalar(
        "tag:yaml.org,2002:str", str.__str__(text), None if text.isprintable() else '"'
    ),
)
add_resolvers(_Dumper)


def to_yaml(data: Mapping[str, Any], *, compact: bool = False) -> str:
    """Write plain data as block style YAML that `parse_yaml` reads back equal.

    ``data``: nested mappings with text keys, lists, tuples, text, numbers, booleans and None; the
    order of keys is kept. ``compact``: short innermost mappings and lists on a line each, as people
    write them.
    """
    return yaml.dump(
        data,
        Dumper=_CompactDumper if compact else _Dumper,
        sort_keys=False,
        allow_unicode=True,
        width=float("inf"),
        indent=2,
        default_flow_style=False,
    )


def to_json(record: Any, **layout: Any) -> str:
    """Write a record as strict JSON: no NaN, no infinity, and zero without a sign."""
    return json.dumps(_without_signed_zeros(record), allow_nan=False, **layout)


def _without_signed_zeros(record: Any) -> Any:
    """Make zeros positive: the sign of a zero is an accident of the arithmetic."""
    if isinstance(record, Mapping):
        return {key: _without_signed_zeros(value) for key, value in record.items()}
    if isinstance(record, list | tuple):
        return [_without_signed_zeros(value) for value in record]
    return record + 0.0 if isinstance(record, float) else record


def file_text(head: str, data: Mapping[str, Any]) -> str:
    """Return the text of an aircraft's or mission's file: origin, format and data."""
    first = {FORMAT_KEY: data.get(FORMAT_KEY, FORMAT_VERSION)}
    return f"# {head}\n{to_yaml(first | dict(data))}"


def names_a_device(name: str) -> bool:
    """Return true for a file name that Windows takes for a device, with any suffix.

    Microsoft, Naming Files, Paths, and Namespaces.
    """
    return name.partition(".")[0].rstrip(" ").upper() in _DEVICES


def write_bytes_atomically(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file completely or not at all.

    ``path``: file to write; a symbolic link is replaced, unless it leads to a device or pipe, as
    ``/dev/stdout`` does.
    """
    write_files_atomically({path: data})


@contextmanager
def _writing(name: str) -> Iterator[None]:
    """Refuse what cannot be written, by its name and the reason."""
    try:
        yield
    except (OSError, ValueError) as error:
        raise OutputError(f"cannot write {name}: {writing_trouble(error)}") from error


def write_files_atomically(
    contents: Mapping[str | os.PathLike[str], bytes], *, follow: bool = True
) -> None:
    """Write several files completely, or none of them.

    Files are written beside their targets, then replace them. A symbolic link is replaced itself,
    unless it leads to a device or pipe and may be followed there.
    """
    staged: list[tuple[Path, bytes, Path | None]] = []
    try:
        for path, data in contents.items():
            with _writing(printable(os.fspath(path))):
                target = Path(path)
                link = target.is_symlink()
                mode = target.stat().st_mode if target.exists() and (follow or not link) else None
                if mode is not None and stat.S_ISDIR(mode):
                    raise IsADirectoryError
                # A device or a pipe must be written to, never replaced by a file.
                is_file = mode is None or stat.S_ISREG(mode)
                scratch = target.parent / f".{os.urandom(8).hex()}.tmp" if is_file else None
                staged.append((target, data, scratch))
                if scratch is None:
                    continue
                with scratch.open("xb") as file:  # with the permissions of an ordinary new file
                    file.write(data)
                    file.flush()
                    os.fsync(file.fileno())
                if mode is not None and not link:  # those of the file that it will replace
                    scratch.chmod(stat.S_IMODE(mode))
        for target, data, scratch in staged:
            with _writing(printable(os.fspath(target))):
                if scratch is None:
                    target.write_bytes(data)
                else:
                    scratch.replace(target)
    finally:
        for _, _, scratch in staged:
            if scratch is not None:
                with suppress(OSError):  # it may not have been made
                    scratch.unlink()


def write_folder(folder: Path, contents: Mapping[str, bytes]) -> None:
    """Write all files into a folder, or none; the folder is made if missing.

    A symbolic link in it is replaced even if it leads to a device: the folder may be untrusted.
    """
    made = make_folder(folder)
    try:
        write_files_atomically({folder / file: d for file, d in contents.items()}, follow=False)
    except BaseException:  # a signal, too, leaves no empty folder
        _remove_empty(made)
        raise


def make_folder(folder: Path) -> list[Path]:
    """Make a folder and its parents; return the new ones, innermost first."""
    made: list[Path] = []
    name = printable(os.fspath(folder))
    try:
        made = [path for path in (folder, *folder.parents) if not path.exists()]
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        _remove_empty(made)
        why = writing_trouble(error)
        if isinstance(error, FileExistsError):
            why = f"{name} is not a folder"
        elif isinstance(error, FileNotFoundError):  # all that lacked was to be made
            why = "no folder can be made there"
        raise OutputError(f"cannot write to {name}: {why}") from error
    return made


def _remove_empty(folders: list[Path]) -> None:
    for path in folders:
        with suppress(OSError):  # not empty: somebody else's by now
            path.rmdir()


def check_writable_file(path: str | os.PathLike[str]) -> None:
    """Refuse a file that cannot be written, before the work for it begins."""
    target, name = Path(path), printable(os.fspath(path))
    with _writing(name):  # it may be too long, or in a folder that may not be looked into
        if target.is_dir():
            raise IsADirectoryError
        is_file = target.is_file() or not target.exists()
    if is_file:  # else a device or a pipe
        probe(target.parent, name)


def probe(folder: Path, name: str) -> None:
    """Create and delete a file in a folder: permissions alone do not tell whether it works."""
    try:
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".", suffix=".tmp") as scratch:
            scratch.write(b"probe")
    except OSError as error:
        missing = isinstance(error, FileNotFoundError) and folder.is_dir()
        why = "no file can be made there" if missing else writing_trouble(error)
        raise OutputError(f"cannot write {name}: {why}") from error


def check_writable_folder(folder: Path) -> None:
    """Refuse a folder that cannot be written to, before the work for it begins.

    A folder that does not exist is made, and taken away again.
    """
    made = make_folder(folder)
    try:
        probe(folder, f"to {printable(os.fspath(folder))}")
    finally:
        _remove_empty(made)


def writing_trouble(error: OSError | ValueError) -> str:
    """Return the reason why a file cannot be written, in words."""
    if isinstance(error, FileNotFoundError):
        return "its folder does not exist"
    if isinstance(error, NotADirectoryError):
        return "a part of the path is a file, not a folder"
    if isinstance(error, IsADirectoryError):
        return "it is a folder"
    if isinstance(error, OSError):
        return (error.strerror or str(error)).lower()
    return "not a valid file name"
