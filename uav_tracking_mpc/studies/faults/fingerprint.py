"""A digest of what an object holds, to see whether a call has changed it."""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Callable, Collection
from enum import Enum
from typing import Any

import numpy as np

PACKAGE = __name__.partition(".")[0]
_PLAIN = frozenset((type(None), bool, int, float, str))


def fingerprint(things: Collection[Any], leaving_out: Collection[str] = ()) -> bytes:
    """Digest of values, arrays, containers and this package's objects, all the way down.

    Objects of others count by their type alone.

    Args:
        things: What to look at.
        leaving_out: Names of attributes that may change.
    """
    digest = hashlib.blake2b(digest_size=16)
    for thing in things:
        _feed(thing, leaving_out, digest.update)
    return digest.digest()


def _feed(thing: Any, leaving_out: Collection[str], feed: Callable[[bytes], None]) -> None:
    kind = type(thing)
    if kind in _PLAIN:
        feed(repr(thing).encode())
    elif kind is np.ndarray:
        feed(thing.tobytes())
    elif isinstance(thing, (list, tuple, deque)):
        feed(b"[%d" % len(thing))
        for item in thing:
            _feed(item, leaving_out, feed)
    elif kind is dict:
        for key, value in thing.items():
            feed(repr(key).encode())
            _feed(value, leaving_out, feed)
    elif kind.__module__.startswith(PACKAGE) and not issubclass(kind, Enum):
        for name, value in vars(thing).items():
            if name not in leaving_out:
                feed(name.encode())
                _feed(value, leaving_out, feed)
    elif isinstance(thing, (Enum, np.generic)):
        feed(repr(thing).encode())
    else:
        feed(kind.__name__.encode())
