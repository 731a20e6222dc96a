"""A ROS domain of one's own, so that two flights on one machine do not mix."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager

FIRST_DOMAIN, LAST_DOMAIN = 1, 101  # what Linux's ephemeral ports leave free
GREATEST_DOMAIN = 232  # what DDS's port numbers leave room for


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


def domain_number(text: str) -> int:
    """ROS_DOMAIN_ID given as text.

    Args:
        text: What was typed.

    Raises:
        ValueError: Not an integer from 0 to 232.
    """
    number = int(text)
    if not 0 <= number <= GREATEST_DOMAIN:
        raise ValueError(f"domain is {number}, must be from 0 to {GREATEST_DOMAIN}")
    return number
