#!/usr/bin/env bash
# OSQP: a contact problem becomes "primal infeasible" when the mesh is refined.
#
# Guess: a quadratic program that has a solution is solved, or the iteration limit is reached; whether a constraint is written
#   in m or in mm changes the number of iterations and not the status.
# Version: osqp 1.1.3.
# Behaviour: the status is "primal infeasible" after 25 iterations for feasible problems in which a constraint row has only
#   coefficients below 1e-4. A vector dy counts as a certificate of infeasibility if max|A^T dy| <= eps_prim_inf max|dy| and
#   b^T dy <= eps_prim_inf max|dy|, with eps_prim_inf = 1e-4. Every dy along a row with small coefficients meets the first
#   condition, whether or not A^T dy = 0 can be reached. The test uses the coefficients of the user, not the equilibrated ones.
# Output: nip of a cylinder (R 0.2 m, line load 2000 N/m) on 6 mm of an elastic foundation, pressures p >= 0 with
#   sum(p dx) = load: 50 nodes (dx 1.2e-4 m) solved; 100 nodes (dx 6.1e-5 m) primal infeasible; 100 nodes with the load balance
#   multiplied by 10, or divided by dx, solved. Two unknowns, a (x1 + x2) = 1: infeasible at a = 9e-5, solved at 1.1e-4.
# Why it matters: the load balance of a contact problem in SI units has the mesh width in m as its coefficient, and
#   "infeasible" is a statement about physics (no equilibrium), not about accuracy; a mesh study seems to show that the nip
#   cannot carry the load.
# Remedy: divide the load balance by the mesh width (sum(p) = load / dx).
. "$(dirname "$0")/environment" osqp==1.1.3 numpy==2.4.6 scipy==1.17.1
python - <<'EOF'
import numpy as np
import osqp
import scipy.sparse as sp


def status(hessian, linear, constraints, lower, upper):
    solver = osqp.OSQP()
    solver.setup(hessian.tocsc(), linear, constraints.tocsc(), lower, upper, verbose=False, max_iter=20000)
    return solver.solve(raise_error=False).info.status


def nip(nodes, factor=1.0):
    x, dx = np.linspace(-3e-3, 3e-3, nodes, retstep=True)
    gap, stiffness, load = x**2 / 0.4, 1e10, 2000.0
    rows = sp.vstack([np.full((1, nodes), factor * dx), sp.eye(nodes)])
    lower = np.r_[factor * load, np.zeros(nodes)]
    upper = np.r_[factor * load, np.full(nodes, np.inf)]
    return status(sp.diags(np.full(nodes, dx / stiffness)), gap * dx, rows, lower, upper)


def pair(a):
    return status(sp.eye(2), np.zeros(2), sp.csc_matrix([[a, a]]), np.ones(1), np.ones(1))


observed = [nip(50), nip(100), nip(100, 10.0), nip(100, 99 / 6e-3), pair(9e-5), pair(1.1e-4)]
print(observed)
if observed != ["solved", "primal infeasible", "solved", "solved", "primal infeasible", "solved"]:
    raise SystemExit(f"changed: {observed}")
print("as stated")
EOF
