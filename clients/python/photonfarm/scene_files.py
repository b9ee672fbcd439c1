"""A scene on disk as the bytes that are uploaded: a file alone, or a zip archive with everything that it refers to."""

from __future__ import annotations

import io
import json
import re
import zipfile
from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from urllib.parse import unquote

from .errors import found_here

# The archive's comment names the scene file, whatever stands beside it.
SCENE_COMMENT = "photonfarm scene: "
# Files of these kinds may name further files.
NAMING_SUFFIXES = {".xml", ".json", ".gltf", ".glb", ".mgf", ".pbrt", ".obj", ".mtl"}
# A file's name in any of these formats: what stands in quotes, or a word without spaces.
NAME = re.compile(r'"([^"\n]+)"|\'([^\'\n]+)\'|([^\s"\'<>=,]+)')
LONGEST_NAME = 1024
# The oldest time that a zip archive can tell: equal scenes become equal bytes, which the coordinator keeps once.
NO_TIME = (1980, 1, 1, 0, 0, 0)


def pack(path: str | PathLike[str], scene: str | None = None) -> bytes:
    """The bytes to upload for a scene file, a zip archive, or a folder, whose scene file `scene` names where it is not plain which one it is."""
    place = Path(path)
    try:
        if place.is_dir():
            return pack_folder(place, scene)
        if scene is not None:
            raise found_here("bad-file", f"\"{place}\" is no folder, but a scene file in it is named", "give the folder, or leave the name out")
        return pack_file(place)
    except OSError as problem:
        raise found_here("bad-file", f"cannot read \"{place}\": {problem.strerror}", "check the name and the permissions") from problem


def pack_file(file: Path) -> bytes:
    """A scene file and the files of its folder that it names, by way of others too."""
    content = file.read_bytes()
    if content.startswith(b"PK"):
        return content
    folder = file.parent.resolve()
    files = {Path(file.name): content}
    unread = [Path(file.name)]
    while unread:
        for name in sorted(named_files(folder, unread.pop(), files)):
            files[name] = (folder / name).read_bytes()
            unread.append(name)
    return content if len(files) == 1 else write_zip(files, file.name)


def pack_folder(folder: Path, scene: str | None) -> bytes:
    """All files of a folder but hidden ones."""
    names = [path.relative_to(folder) for path in folder.rglob("*") if path.is_file()]
    names = [name for name in names if not any(part.startswith(".") for part in name.parts)]
    inner = {name.parts[0] for name in names}
    if len(inner) == 1 and Path(*inner) not in names:
        # The coordinator takes a single folder round everything off, too, and would not find the scene under its old name.
        return pack_folder(folder / Path(*inner), scene and str(Path(scene).relative_to(*inner)))
    if scene is not None and Path(scene) not in names:
        raise found_here("bad-file", f"there is no file \"{scene}\" in \"{folder}\"", "name the scene file as seen from the folder")
    return write_zip({name: (folder / name).read_bytes() for name in names}, scene and Path(scene).as_posix())


def named_files(folder: Path, name: Path, known: Iterable[Path]) -> set[Path]:
    """Files in the folder that the file `name` names, as seen from the folder or from the file itself."""
    if name.suffix.lower() not in NAMING_SUFFIXES:
        return set()
    text = naming_text((folder / name).read_bytes(), name.suffix.lower())
    words = {next(filter(None, match)) for match in NAME.findall(text)}
    words |= {part for word in words for part in word.split()}
    found = {inside(folder, base / spelled) for word in words for spelled in (word, unquote(word)) for base in (folder, folder / name.parent)}
    return {path for path in found if path is not None} - set(known)


def naming_text(content: bytes, suffix: str) -> str:
    """The part of a file in which names may stand."""
    if suffix == ".obj":
        # Only its material libraries; the rest is numbers.
        return "\n".join(line.decode("utf-8", "replace") for line in content.splitlines() if line.lstrip().startswith(b"mtllib"))
    if content.startswith(b"glTF"):
        # Behind a header of 20 bytes stands the JSON, whose length the header tells.
        content = content[20 : 20 + int.from_bytes(content[12:16], "little")]
    text = content.decode("utf-8", "replace")
    if suffix in (".json", ".gltf", ".glb"):
        # Escapes of JSON, such as \/ and \u00e9, are undone.
        text = re.sub(r'"(?:[^"\\]|\\.)*\\(?:[^"\\]|\\.)*"', lambda match: f'"{json.loads(match[0], strict=False)}"', text)
    return text.replace("\\", "/")


def inside(folder: Path, path: Path) -> Path | None:
    """The path as seen from the folder, if it is a file that lies in it: a scene from elsewhere takes nothing else along."""
    if len(str(path)) > LONGEST_NAME or "\0" in str(path):
        return None
    try:
        resolved = path.resolve()
        return resolved.relative_to(folder) if resolved.is_file() else None
    except (OSError, ValueError, RuntimeError):
        # What only looked like a file's name.
        return None


def write_zip(files: dict[Path, bytes], scene: str | None) -> bytes:
    """A zip archive whose bytes depend on the files' names and contents only."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            archive.writestr(zipfile.ZipInfo(name.as_posix(), NO_TIME), files[name], zipfile.ZIP_DEFLATED)
        if scene is not None:
            archive.comment = (SCENE_COMMENT + scene).encode()
    return buffer.getvalue()
