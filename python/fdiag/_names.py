"""Names that are nearly right."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = ["nearest"]


def nearest(name: str, known: Iterable[str]) -> str:
    """What to say behind an unknown name.

    >>> nearest("elbo", ["shoulder", "elbow"])
    ', did you mean `elbow`? There are `shoulder`, `elbow`'
    >>> nearest("x", [])
    '; there is none'
    """
    names = list(known)
    if not names:
        return "; there is none"
    near = difflib.get_close_matches(name, names, 1)
    hint = f", did you mean `{near[0]}`?" if near else ";"
    shown = ", ".join(f"`{known}`" for known in names[:20])
    more = f" and {len(names) - 20} more" if len(names) > 20 else ""
    return f"{hint} {'There' if near else 'there'} are {shown}{more}"
