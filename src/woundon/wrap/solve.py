from __future__ import annotations
from dataclasses import dataclass, replace
from math import pi
import numpy as np
from ..assembly import half_width_guess, contact_radius
from ..contact.discretisation import discretisation
from ..contact.stick_slip import Ending, solve_stick_slip
from ..contact.width import width_for_load
from ..problems import NipProblem
from .equations import Loads, WrapEquations, WrapState
from .grid import WrapGrid, wrap_grid

def solve(problem, roll_wrap=pi, drum_wrap=0.0, friction=None, nodes=65, roll_cells=64, drum_cells=48, verbose=False, hoop=True):
    loads = Loads(roll_wrap > 0, drum_wrap > 0, problem.roll_friction if friction is None else friction)
    R1, R2 = problem.roll.radius, problem.drum.radius
    levels = [nodes]
    while levels[0] > 24: levels.insert(0, (levels[0] + 1)//2)
    start = None
    power = 2.0
    out = []
    for M in levels:
        disc = discretisation("graded", M)
        div = (nodes-1)//(M-1)
        def grid_at(a):
            ra = (roll_wrap*R1 - a)/a if loads.roll_arc else 0.0
            da = drum_wrap*R2/a if loads.drum_arc else 0.0
            return wrap_grid(disc.grid, da, drum_cells//div, ra, roll_cells//div)
        a = half_width_guess(problem) if start is None else start[1].half_width
        g = grid_at(a)
        if start is None:
            T = np.full(g.size, problem.web_tension + 0.3*problem.roll_friction*problem.nip_load*0+50)
            bend = np.full(g.size, 1/R1); bend[:g.last] = -1/R2
            zones = None
        else:
            og, st = start
            xo = og.nodes*st.half_width; xn = g.nodes*a
            T = np.interp(xn, xo, st.tension); bend = np.interp(xn, xo, st.bend)
            m1 = og.size-og.first-2
            zs = st.solution.state
            oldr = xo[og.first+1:og.size-1]; newr = xn[g.first+1:g.size-1]
            oldd = xo[1:og.last]; newd = xn[1:g.last]
            near = lambda o,n,z: z[np.searchsorted((o[1:]+o[:-1])/2, n)]
            zones = np.concatenate([near(oldr,newr,zs[:m1]), near(oldd,newd,zs[m1:])])
        memory = dict(T=T, bend=bend, zones=zones)
        def evaluate(a):
            g = grid_at(a)
            eq = WrapEquations(problem, loads, g, a, memory['T'], memory['bend'])
            sol = solve_stick_slip(eq.stick_slip(), memory['zones'])
            if sol.ending is not Ending.SOLVED: raise ArithmeticError(sol.ending)
            st = eq.state(sol)
            memory.update(T=st.tension, bend=st.bend, zones=sol.state)
            load = eq.nip_load(st); 
            if verbose: print(M, f"a={a:.8f} load={load:.4f} NIT={st.tension[g.last]-problem.web_tension:.6f} WOT={st.tension[-1]:.6f} imb={eq.imbalance(st):.2e} solves={sol.solves} pmin={st.roll_pressure[1:].min():.3g} {st.drum_pressure[1:g.last].min():.3g}")
            return (eq, st), load
        for _ in range(10):
            (eq, st), power = width_for_load(evaluate, problem.nip_load, a, 1e-10 if M==nodes else 1e-4, power)
            a = st.half_width
            if eq.imbalance(st) < (1e-9 if M==nodes else 1e-3): break
        start = (eq.grid, st)
        out.append((st.tension[eq.grid.last]-problem.web_tension, st.tension[-1]))
    return eq, st, out
