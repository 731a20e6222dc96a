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

"""Every array of the method, in one record that is allocated once.

One record, because passing thirty arrays from Python costs more than a Newton iteration. Its fields
have sizes known at compile time, so that indices into them fold into constants. A size of 0 is kept
as 1 element that nothing reads.
"""

import numpy as np
from numba import from_dtype
from numba.extending import intrinsic

from .stage import NA, NE, NH, NP, NS, NU, NW, NX, N

# Plans: the iterate and the trial of the line search (they take turns), the best feasible iterate,
# and what the last attempt ended with, from which the next warm start begins. The other rows are
# for the caller to put plans aside.
# (NumPy integers, because numba compiles a function once more for every literal argument.)
FIRST, SECOND, BEST, KEPT = (np.int64(row) for row in range(4))
SPARE = 4  # index of the caller's first row
PLANS = 7
WORKING = FIRST  # multipliers of the iteration; those of row KEPT belong to the plan of that name

STAGES, END, ROWS = np.int64(0), np.int64(1), 2  # indices: what all stages share, and the end
NC = max(NH, NE)  # constraints of a stage, or of the end

FIELDS = {
    # data of the solve
    "x_0": (NX,),
    "p": (N + 1, NP),
    # plans
    "x": (PLANS, N + 1, NX),
    "u": (PLANS, N, NU),
    "a": (PLANS, NA),
    "c": (PLANS, N + 1, NC),  # constraints: h of every stage, e of the end after them
    # cost without constraints, cost with exact penalties, violation, residual of constraints
    "value": (PLANS, 4),
    # multipliers mu and penalty weights rho of the augmented Lagrangian
    "mu": (PLANS, N + 1, NC),
    "rho": (PLANS, ROWS, NC),
    "residual": (ROWS, NC),  # largest |m - mu| / rho at the last multiplier update
    # backward sweep
    "m": (NC,),
    "d": (NC,),
    "curvature": (1,),
    "costate": (NS,),
    "gradient": (NW,),
    "Q": (NW, NW),  # upper triangle
    "q": (NW,),
    "V": (NS, NS),  # upper triangle
    "v": (NS,),
    # Newton step: u + k + K (s - s_now), a + k_a
    "k": (N, NU),
    "K": (N, NU, NS),
    "k_a": (NA,),
    # the quadratic program of one stage
    "hessian": (max(NU, NA), max(NU, NA)),
    "factor": (max(NU, NA), max(NU, NA)),
    "slope": (max(NU, NA),),
    "lower": (max(NU, NA),),
    "upper": (max(NU, NA),),
    "step": (max(NU, NA),),
    "free": (max(NU, NA),),
    # the problem's numbers
    "goal": (NX,),
    "a_guess": (NA,),
    "u_lower": (NU,),
    "u_upper": (NU,),
    "a_lower": (NA,),
    "a_upper": (NA,),
    "m_lower": (ROWS, NC),
    "m_upper": (ROWS, NC),
    # small things
    "l": (1,),
    "u_end": (NU,),  # input after the last stage
    "feedback": (NS,),
    "shifts": (1,),  # stages whose Hessian had to be made positive definite
    "outcome": (8,),
}
WORKSPACE = np.dtype(
    [(name, np.float64, tuple(max(1, size) for size in shape)) for name, shape in FIELDS.items()]
    + [("horizon", np.int64, (1,)), ("ends", np.int64, (1,)), ("instant", np.int64, (2,))],
    align=True,
)

_RECORD = from_dtype(WORKSPACE)


@intrinsic
def record_at(typing_context, address):
    """The record at a memory address.

    Compiled code is given the address, because looking up the type of a structured array at every
    call can cost more than the solve.
    """

    def generate(context, builder, signature, arguments):
        return builder.inttoptr(arguments[0], context.get_value_type(_RECORD))

    return _RECORD(address), generate
