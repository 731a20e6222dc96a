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

"""A ROS domain of one's own, so that two flights on one machine do not mix."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager

FIRST_DOMAIN, LAST_DOMAIN = 1, 101  # what Linux's ephemeral ports leave free


class DomainError(RuntimeError):
    """No domain is free."""


@contextmanager
def own_domain(domain: int | None) -> Iterator[int]:
    """A ROS domain that no other launch on this machine uses.

    A TCP port stands for the domain while it is in use; it carries no traffic.

    Args:
        domain: Take this one instead, whoever else is on it.

    Yields:
        Number of the domain.

    Raises:
        DomainError: All domains are in use.
    """
    if domain is not None:
        yield domain
        return
    count = LAST_DOMAIN - FIRST_DOMAIN + 1
    for offset in range(count):
        candidate = FIRST_DOMAIN + (os.getpid() + offset) % count
        with socket.socket() as claim:
            try:
                claim.bind(("127.0.0.1", 7400 + 250 * candidate))  # where DDS puts its domains
            except OSError:
                continue
            yield candidate
            return
    raise DomainError(f"all ROS domains from {FIRST_DOMAIN} to {LAST_DOMAIN} are in use")
