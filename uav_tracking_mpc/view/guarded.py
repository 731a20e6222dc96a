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

"""An element of the scene or a part of the panel, whoever wrote it: an exception ends it alone."""

from __future__ import annotations

import contextlib
import logging
import weakref
from collections.abc import Callable
from typing import Any

from uav_tracking_mpc.view.panel import PanelPart
from uav_tracking_mpc.view.scene import SceneElement
from uav_tracking_mpc.view.sight import Sight

logger = logging.getLogger(__name__)


class Guarded:
    """Begins with the first sight, and is switched off by its first exception.

    What it has added is hidden then, lest something that is no longer true stays on the page.

    Args:
        name: By which it is found.
        api: Of viser, for the scene or the panel.
        begin: Makes it with that API; None while there is nothing to show.

    Attributes:
        name: As above.
        failure: Why it was switched off, in words; empty while it works.
    """

    def __init__(
        self, name: str, api: Any, begin: Callable[[Any], SceneElement | PanelPart | None]
    ) -> None:
        self.name, self.failure = name, ""
        self._api, self._begin = _Noting(api), begin
        self._shown: SceneElement | PanelPart | None = None

    def show(self, sight: Sight) -> None:
        """Bring it up to date, unless it is switched off.

        Args:
            sight: Of the aircraft.
        """
        if self.failure:
            return
        try:
            if self._shown is None:
                self._shown = self._begin(self._api)
            if self._shown is not None:
                self._shown.show(sight)
        except Exception as error:  # whatever it is, the page and the flight go on
            self.failure = f"{type(error).__name__}: {error}"
            logger.exception("page: %s is switched off", self.name)
            for handle in self._api.added.values():
                with contextlib.suppress(Exception):  # not all that can be added can be hidden
                    handle.visible = False


class _Noting:
    """Passes everything on to an API of viser, and notes what is added through it."""

    def __init__(self, api: Any) -> None:
        self._api = api
        self.added: weakref.WeakValueDictionary[int, Any] = weakref.WeakValueDictionary()

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._api, name)
        if not name.startswith("add_"):
            return found

        def add(*args: Any, **kwargs: Any) -> Any:
            handle = found(*args, **kwargs)
            self.added[id(handle)] = handle  # handles have no hash
            return handle

        return add
