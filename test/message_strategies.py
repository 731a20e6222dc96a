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

"""Hypothesis strategies: what a sender gone wrong makes of a message, any field of it.

Whatever comes out could have come over the wire: types are kept, values are not.
"""

from __future__ import annotations

import copy
import math

from hypothesis import strategies as st

NUMBERS = (math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324, -0.0, 0.0, 1.0, -1.0, 9.99e6)
FACTORS = (-1.0, 1e-3, 0.5, 0.9995, 1.0005, 1.002, 1.1, 2.0, 1e3, 1e160)
TEXTS = ("", " map", "MAP", "odom", "map", "base_link", "earth\n", "m\u00e4p", "map" * 1000)
INTEGERS = {"int32": (-(2**31), 2**31 - 1), "uint32": (0, 2**32 - 1)}
STEPS = (1, -1, 999_999_999, 1_000_000_000)


def is_message(value):
    return hasattr(value, "get_fields_and_field_types")


@st.composite
def changed(draw, message):
    """A copy of a ROS message with one to three fields changed, anywhere in it."""
    message = copy.deepcopy(message)
    for _ in range(draw(st.integers(1, 3))):
        _change(draw, message)
    return message


def _change(draw, message):
    kinds = message.get_fields_and_field_types()
    name = draw(st.sampled_from(list(kinds)))
    value = getattr(message, name)
    if is_message(value):
        _change(draw, value)
    elif isinstance(value, list):
        if value and is_message(value[0]) and draw(st.booleans()):
            _change(draw, draw(st.sampled_from(value)))
        else:
            setattr(message, name, draw(sequences(value)))
    elif isinstance(value, float):
        setattr(message, name, draw(numbers(value)))
    elif isinstance(value, int):
        setattr(message, name, draw(integers(value, *INTEGERS[kinds[name]])))
    elif isinstance(value, str):
        setattr(message, name, draw(st.sampled_from(TEXTS)))
    else:  # an array of numbers, such as a covariance
        value[draw(st.integers(0, len(value) - 1))] = draw(numbers(1.0))


def numbers(value):
    """Special numbers, any number, or one near a value."""
    return st.one_of(
        st.sampled_from(NUMBERS),
        st.floats(),
        st.sampled_from(FACTORS).map(lambda factor: value * factor),
        st.floats(-1e3, 1e3).map(lambda step: value + step),
    )


def integers(value, lowest, highest):
    """Both ends of the type, any integer of it, or one near a value."""
    near = st.sampled_from(STEPS).map(lambda step: min(max(value + step, lowest), highest))
    return st.one_of(st.sampled_from((lowest, highest)), st.integers(lowest, highest), near)


def sequences(values):
    """Shorter, longer or in another order; what it holds stays."""
    if not values:
        return st.just([])
    return st.lists(st.sampled_from(values), max_size=len(values) + 2).map(copy.deepcopy)
