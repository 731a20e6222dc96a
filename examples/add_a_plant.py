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

"""Add a plant: the aircraft slips sideways in its turns, which the controller does not model.

The plant is this one class. It is found by ``FILE.py:CLASS``::

    uav_tracking simulate --config small_uav --set mission.plant=examples/add_a_plant.py:Slipping
"""

import sys
from dataclasses import replace

from uav_tracking_mpc import Measurement, check_plant
from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant

SLIP = 0.25  # s: sideslip angle over turn rate
LAG = 0.5  # s: time constant with which the sideslip follows


class Slipping(VehiclePlant):
    r"""The nose points outside the turn by a sideslip angle.

    .. math:: T \dot\beta = k \dot\psi - \beta

    Args:
        parameters: Those of the vehicle.
    """

    name = "slipping"

    def __init__(self, parameters):
        super().__init__(parameters)
        self.sideslip = 0.0

    def advance(self, duration: float) -> None:
        """See :meth:`Plant.advance`."""
        super().advance(duration)
        self.sideslip += (SLIP * self.rates[0] - self.sideslip) * min(duration / LAG, 1.0)

    @property
    def truth(self) -> Measurement:
        """The nose's heading is what sensors measure; the air comes from ``sideslip`` beside it."""
        along_the_air = super().truth
        return replace(along_the_air, heading=wrap_angle(along_the_air.heading - self.sideslip))


if __name__ == "__main__":
    check_plant(Slipping)
    plant = f"mission.plant={__file__}:Slipping"
    sys.exit(main(["simulate", "--config", "small_uav", "--set", plant, *sys.argv[1:]]))
