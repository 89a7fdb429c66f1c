"""Where the files that a URDF names are."""

from __future__ import annotations

from pathlib import Path
from typing import Callable, Mapping
from urllib.parse import unquote, urlparse

from safe_passage.core.errors import InputError

Packages = Callable[[str], Path]  # a package's folder by its name; raises KeyError: not known


def resolve(uri: str, base: Path | None, packages: Packages | Mapping[str, Path]) -> Path:
    """The file that `uri` names.

    Args:
        uri: package://NAME/PATH, file://PATH, an absolute path, or one relative to `base`.
        base: folder of the URDF's file; None where it came as text.
        packages: folder of a ROS package by its name.

    Raises:
        InputError: names the URI and what is not there.
    """
    parts = urlparse(uri)
    if parts.scheme == "package":
        find = packages.__getitem__ if isinstance(packages, Mapping) else packages
        try:
            path = Path(find(parts.netloc)) / unquote(parts.path).lstrip("/")
        except KeyError:
            raise InputError(f"{uri}: there is no package {parts.netloc!r}") from None
    elif parts.scheme == "file":
        path = Path(unquote(parts.netloc + parts.path))
    elif parts.scheme:
        raise InputError(f"{uri}: only package:// and file:// are known")
    elif Path(uri).is_absolute():
        path = Path(uri)
    elif base is None:
        raise InputError(f"{uri}: relative, but the URDF came without a folder")
    else:
        path = base / uri
    if not path.is_file():
        raise InputError(f"{uri}: there is no file {path}")
    return path
