"""Sizes and equations of one problem; written by ``mpc/stage_code.py``.

This one is a double integrator under steps of 0.1 s, l = |x|^2 + u^2 / 10, V_f = 10 |x|^2.
"""

from .straight_line import straight_line

N = 10  # stages
NX = 2  # states x
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
t1 = load 0 1
t2 = mul 0.1 t1
t3 = add t0 t2
store 0 0 t3
t5 = load 1 0
t6 = mul 0.1 t5
t7 = add t1 t6
store 0 1 t7
t9 = mul t0 t0
t10 = mul t1 t1
t11 = add t9 t10
t12 = mul t5 t5
t13 = mul 0.1 t12
t14 = add t11 t13
store 1 0 t14
""")

# (x, u, a, p, costate, curvature, m, d, V, v) -> (Q, q, gradient)
stage_quadratic = straight_line("""
t0 = load 8 0
t1 = add 2.0 t0
store 0 0 t1
t3 = mul 0.1 t0
t4 = load 8 1
t5 = add t3 t4
store 0 1 t5
t7 = mul 0.1 t4
store 0 2 t7
t9 = mul 0.1 t5
t10 = load 8 3
t11 = add t7 t10
t12 = add t9 t11
t13 = add 2.0 t12
store 0 4 t13
t15 = mul 0.010000000000000002 t4
t16 = mul 0.1 t10
t17 = add t15 t16
store 0 5 t17
t19 = mul 0.010000000000000002 t10
t20 = add 0.2 t19
store 0 8 t20
t22 = load 4 0
t23 = load 0 0
t24 = mul 2.0 t23
t25 = add t22 t24
t26 = load 9 0
t27 = sub t26 t22
t28 = add t25 t27
store 1 0 t28
t30 = load 4 1
t31 = mul 0.1 t22
t32 = add t30 t31
t33 = load 0 1
t34 = mul 2.0 t33
t35 = add t32 t34
t36 = mul 0.1 t27
t37 = load 9 1
t38 = sub t37 t30
t39 = add t36 t38
t40 = add t35 t39
store 1 1 t40
t42 = mul 0.1 t30
t43 = load 1 0
t44 = mul 0.2 t43
t45 = add t42 t44
t46 = mul 0.1 t38
t47 = add t45 t46
store 1 2 t47
store 2 0 t25
store 2 1 t35
store 2 2 t45
""")

# (x, a, p) -> (l, e)
terminal_values = straight_line("""
t0 = load 0 0
t1 = mul t0 t0
t2 = load 0 1
t3 = mul t2 t2
t4 = add t1 t3
t5 = mul 10.0 t4
store 0 0 t5
""")

# (x, a, p, m, d) -> (V, v)
terminal_quadratic = straight_line("""
store 0 0 20.0
store 0 1 0.0
store 0 3 20.0
t3 = load 0 0
t4 = mul 20.0 t3
store 1 0 t4
t6 = load 0 1
t7 = mul 20.0 t6
store 1 1 t7
""")

# (x, u, a, p) -> (u_end)
continuation = straight_line("""
t0 = load 1 0
store 0 0 t0
""")
