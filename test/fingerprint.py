# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""A digest of what an object holds, to see whether a call has changed it."""

from __future__ import annotations

import hashlib
from collections import deque
from enum import Enum

import numpy as np

PACKAGE = "uav_tracking_mpc"
PLAIN = frozenset((type(None), bool, int, float, str))


def fingerprint(things, leaving_out=()):
    """Digest of values, arrays, containers and the package's objects, all the way down.

    Objects of others count by their type alone; attributes named in ``leaving_out`` do not count.
    """
    digest = hashlib.blake2b(digest_size=16)
    for thing in things:
        _feed(thing, leaving_out, digest.update)
    return digest.digest()


def fingerprints(things, leaving_out=()):
    """Digests of things by name, and in their place those of what the package's objects hold."""
    digests = {}
    for name, thing in things.items():
        parts = {"": thing}
        if type(thing).__module__.startswith(PACKAGE) and hasattr(thing, "__dict__"):
            parts = {f".{part}": value for part, value in vars(thing).items()}
        for part, value in parts.items():
            if part.lstrip(".") not in leaving_out:
                digests[name + part] = fingerprint([value], leaving_out)
    return digests


def _feed(thing, leaving_out, feed):
    kind = type(thing)
    if kind in PLAIN:
        feed(repr(thing).encode())
    elif kind is np.ndarray:
        feed(thing.tobytes())
    elif kind in (list, tuple, deque) and all(type(item) in PLAIN for item in thing):
        feed(repr(thing).encode())
    elif kind in (list, tuple, deque):
        feed(b"[%d" % len(thing))
        for item in thing:
            _feed(item, leaving_out, feed)
    elif kind is dict:
        for key, value in thing.items():
            feed(repr(key).encode())
            _feed(value, leaving_out, feed)
    elif isinstance(thing, (Enum, np.generic)):
        feed(repr(thing).encode())
    elif isinstance(thing, tuple):
        _feed(tuple(thing), leaving_out, feed)
    elif kind.__module__.startswith(PACKAGE) and hasattr(thing, "__dict__"):
        for name, value in vars(thing).items():
            if name not in leaving_out:
                feed(name.encode())
                _feed(value, leaving_out, feed)
    else:
        feed(kind.__name__.encode())
