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

"""Sizes and equations of one problem; written by ``mpc/stage_code.py``.

This one is x+ = x + u with l = x^2 + u^2 and V_f = 2 x^2.
"""

from .compiling import straight_line

N = 5  # stages
NX = 1  # states x
NU = 1  # inputs u
NA = 0  # decisions a, constant over the horizon
NP = 0  # parameters p of a stage
NH = 0  # stage inequalities h
NE = 0  # terminal constraints e
NS = NX + NA  # extended state s = (x, a)
NW = NS + NU  # w = (s, u)

# (x, u, a, p) -> (f, l, h)
stage_values = straight_line("""
t0 = load 0 0
t1 = load 1 0
t2 = add t0 t1
store 0 0 t2
t4 = mul t0 t0
t5 = mul t1 t1
t6 = add t4 t5
store 1 0 t6
""")

# (x, u, a, p, costate, curvature, m, d, V, v) -> (Q, q, gradient)
stage_quadratic = straight_line("""
t0 = load 8 0
t1 = add 2.0 t0
store 0 0 t1
store 0 1 t0
store 0 3 t1
t5 = load 4 0
t6 = load 0 0
t7 = mul 2.0 t6
t8 = add t5 t7
t9 = load 9 0
t10 = sub t9 t5
t11 = add t8 t10
store 1 0 t11
t13 = load 1 0
t14 = mul 2.0 t13
t15 = add t5 t14
t16 = add t15 t10
store 1 1 t16
store 2 0 t8
store 2 1 t15
""")

# (x, a, p) -> (l, e)
terminal_values = straight_line("""
t0 = load 0 0
t1 = mul t0 t0
t2 = mul 2.0 t1
store 0 0 t2
""")

# (x, a, p, m, d) -> (V, v)
terminal_quadratic = straight_line("""
store 0 0 4.0
t1 = load 0 0
t2 = mul 4.0 t1
store 1 0 t2
""")

# (x, u, a, p) -> (u_end)
continuation = straight_line("""
t0 = load 1 0
store 0 0 t0
""")
