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

"""HTML pages that need no other file: style and pictures are inside."""

from __future__ import annotations

import base64
from collections.abc import Callable
from importlib import resources
from typing import Any

from jinja2 import Environment, StrictUndefined


def render(
    package: str, template: str, filters: dict[str, Callable[..., str]], **values: Any
) -> str:
    """Fill in a template.

    Args:
        package: That holds the template.
        template: Name of its file.
        filters: Functions that the template applies, by name.
        values: What the template names.

    Returns:
        The page; what is text in the values is escaped.
    """
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters.update(filters)
    source = resources.files(package).joinpath(template).read_text("utf-8")
    return environment.from_string(source).render(**values)


def embedded(png: bytes) -> str:
    """A picture as an address that holds it.

    Args:
        png: Content of a PNG file.
    """
    return "data:image/png;base64," + base64.b64encode(png).decode()
