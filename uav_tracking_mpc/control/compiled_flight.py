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

"""Where the machine code is kept that a controller of given parameters flies by."""

from __future__ import annotations

from pathlib import Path

from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.formulation.formulation import solver_as_told
from uav_tracking_mpc.mpc.compilation import Compilation
from uav_tracking_mpc.mpc.method_cache import method_folder
from uav_tracking_mpc.settings.tracking import TrackingParameters


def compiled_into(parameters: TrackingParameters) -> Path | None:
    """Folder of the machine code, whether it is made yet or not.

    Args:
        parameters: What is flown.

    Returns:
        None where nothing is compiled for it.

    Raises:
        ParameterError: It cannot be flown.
        NotImplementedError: The problem uses an operation that cannot be compiled.
    """
    formulation = formulation_of(parameters, solver_as_told(lambda: False))
    if formulation is None or parameters.solver != "newton":
        return None
    return method_folder(formulation.solver.problem)


def compile_flight(parameters: TrackingParameters) -> Path | None:
    """Return when the machine code is there; where it is already, at once.

    Args:
        parameters: What is flown.

    Returns:
        As of :func:`compiled_into`.

    Raises:
        ParameterError: It cannot be flown.
        CompilationError: It cannot be compiled.
    """
    folder = compiled_into(parameters)
    if folder is not None:
        Compilation(folder).wait()
    return folder
