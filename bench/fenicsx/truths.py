#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Random stacks by FEniCSx: the truths that judge lcrig's own elements.

Reads stacks, one JSON object a line (`model_study describe FIRST COUNT`), and writes one line of
CSV for each: the slope of the capacitance at zero load on three meshes or, with a pressure, the
change of capacitance at finite strain on three milder meshes. Written from docs/model.md alone;
nothing is shared with model/. Displacements of degree 4 to 6 on rectangles, integrated twice as
well as they need to be, that shrink geometrically towards the rim and towards every face:
exponential convergence at the corners, and every decay length is met by some cell. Sparse LU by
MUMPS. Finite strain takes stacks that a pressure loads, not a plate.

    model_study describe 900001 80 | python3 truths.py > truths.csv
    model_study describe 900001 80 | python3 truths.py 30 > truths-30kPa.csv

Needs Debian's python3-dolfinx 0.5 (in a root of its own; it is large). A stack is left out where
this formulation cannot describe it (rigid layers and electrodes, which are ties; nu above 0.4999)
or where its finest mesh is too large.
"""
import json
import logging
import sys
import time

import numpy as np

logging.disable(logging.INFO)
import ufl
from dolfinx import fem, mesh, nls
from mpi4py import MPI
from petsc4py import PETSc

VACUUM_fF_mm = 8.8541878128  # permittivity, F/m times 1e12
LEVELS = ((4, 4), (6, 5), (8, 6))  # halvings towards a face (by RATIO), degree
# For finite strain: smaller cells at a bonded rim fold over before the load is reached.
FINITE_LEVELS = ((1, 4), (2, 4), (3, 4))
LOAD_STEPS = 8
LEAST_STEP = 1 / 200  # of the load
RATIO = 0.3
RIM_RATIO = 0.45
MOST_UNKNOWNS = 350_000  # with more, the factors do not fit into 20 GiB
MOST_FINITE_UNKNOWNS = 60_000  # a few minutes


def towards_both(low, high, depth):
    """Edges from low to high that shrink towards both ends."""
    half = (high - low) / 2
    near = low + half * RATIO ** np.arange(depth, 0, -1)
    return np.concatenate([[low], near, [low + half], (low + high - near)[::-1], [high]])


def towards_rim(radius, least):
    """Edges from the axis to the rim that shrink towards the rim."""
    steps = int(np.ceil(np.log(least / radius) / np.log(RIM_RATIO)))
    return np.concatenate([[0.0], radius * (1 - RIM_RATIO ** np.arange(1, steps + 1)), [radius]])


def tensor_mesh(radii, heights):
    cells = [len(radii) - 1, len(heights) - 1]
    grid = mesh.create_rectangle(MPI.COMM_SELF, [np.zeros(2), np.array(cells, dtype=float)], cells,
                                 mesh.CellType.quadrilateral)
    points = grid.geometry.x
    columns, rows = np.rint(points[:, 0]).astype(int), np.rint(points[:, 1]).astype(int)
    points[:, 0], points[:, 1] = radii[columns], heights[rows]
    return grid


def can_be_described(stack):
    layers = stack["layers"]
    if any(layer["rigid"] or layer["poisson_ratio"] > 0.4999 for layer in layers):
        return False
    if stack["faces"] != "bonded_laminate":
        return stack["faces"] == "bonded_base"
    above = [layer["soft"] for layer in layers[1:]] + [True]  # the top counts: its electrode is rigid
    return not any(layer["soft"] and next_soft for layer, next_soft in zip(layers, above))


class Study:
    """One stack on one mesh; lengths in mm, stresses in kPa."""

    def __init__(self, stack, depth, degree):
        self.stack, self.layers, self.degree = stack, stack["layers"], degree
        thickness = np.array([layer["thickness_mm"] for layer in self.layers])
        self.faces = np.concatenate([[0.0], np.cumsum(thickness)])
        edges = [towards_both(a, b, depth)[:-1] for a, b in zip(self.faces[:-1], self.faces[1:])]
        heights = np.concatenate(edges + [[self.faces[-1]]])
        self.radius = stack["diameter_mm"] / 2
        self.radii = towards_rim(self.radius, thickness.min() / 2 * RATIO**depth)
        self.grid = tensor_mesh(self.radii, heights)
        self.space = fem.VectorFunctionSpace(self.grid, ("CG", degree))
        self.dx = ufl.dx(metadata={"quadrature_degree": 2 * degree + 1})
        self.r = ufl.SpatialCoordinate(self.grid)[0]

    def unknowns(self):
        return 2 * self.space.dofmap.index_map.size_global

    def by_layer(self, values):
        constant = fem.FunctionSpace(self.grid, ("DG", 0))
        field = fem.Function(constant)
        layer = np.searchsorted(self.faces, constant.tabulate_dof_coordinates()[:, 1]) - 1
        field.x.array[:] = np.asarray(values)[layer]
        return field

    def strain(self, u):
        shear = (u[0].dx(1) + u[1].dx(0)) / 2
        return ufl.as_matrix([[u[0].dx(0), 0, shear], [0, u[0] / self.r, 0],
                              [shear, 0, u[1].dx(1)]])

    def stiffness(self, u, v):
        young = np.array([layer["youngs_modulus_kPa"] for layer in self.layers])
        nu = np.array([layer["poisson_ratio"] for layer in self.layers])
        mu = self.by_layer(young / (2 * (1 + nu)))
        lame = self.by_layer(young * nu / ((1 + nu) * (1 - 2 * nu)))
        a, b = self.strain(u), self.strain(v)
        return (2 * mu * ufl.inner(a, b) + lame * ufl.tr(a) * ufl.tr(b)) * self.r * self.dx

    def held(self, component, where, value=0.0):
        facets = mesh.locate_entities_boundary(self.grid, 1, where)
        part = self.space.sub(component)
        return fem.dirichletbc(PETSc.ScalarType(value),
                               fem.locate_dofs_topological(part, 1, facets), part)

    def conditions(self):
        def base(x):
            return np.isclose(x[1], 0)

        conditions = [self.held(0, lambda x: np.isclose(x[0], 0)), self.held(0, base),
                      self.held(1, base)]
        if self.stack["top"] != "pressure":  # pushed down by 1 mm, scaled afterwards
            conditions.append(self.held(1, self.is_top, -1.0))
        if self.stack["top"] == "bonded_plate":
            conditions.append(self.held(0, self.is_top))
        return conditions

    def is_top(self, x):
        return np.isclose(x[1], self.faces[-1])

    def load(self, v):
        if self.stack["top"] != "pressure":
            return fem.Constant(self.grid, PETSc.ScalarType(0)) * v[0] * self.r * self.dx
        facets = np.sort(mesh.locate_entities_boundary(self.grid, 1, self.is_top))
        tags = mesh.meshtags(self.grid, 1, facets, np.ones(len(facets), dtype=np.int32))
        ds = ufl.Measure("ds", domain=self.grid, subdomain_data=tags)
        return fem.Constant(self.grid, PETSc.ScalarType(-1)) * v[1] * self.r * ds(1)

    def prepare_slope(self):
        """What finds the slope, with its forms compiled and its matrix laid out."""
        u, v = ufl.TrialFunction(self.space), ufl.TestFunction(self.space)
        options = {"ksp_type": "preonly", "pc_type": "lu", "pc_factor_mat_solver_type": "mumps",
                   "mat_mumps_icntl_14": 100}
        problem = fem.petsc.LinearProblem(self.stiffness(u, v), self.load(v), self.conditions(),
                                          petsc_options=options)
        energy = fem.form(self.stiffness(problem.u, problem.u))
        closing = fem.form(self.closing(problem.u))

        def slope_fF_kPa():
            problem.solve()
            for part in (problem.solver, problem.A, problem.b):  # nothing else frees the factors
                part.destroy()
            per_kPa = 1.0
            if self.stack["top"] != "pressure":
                per_kPa = self.radius**2 / 2 / fem.assemble_scalar(energy)
            return 2 * np.pi * VACUUM_fF_mm * per_kPa * fem.assemble_scalar(closing)

        return slope_fF_kPa

    def closing(self, field):
        """The integral of what the gaps lose, weighted as the capacitance does."""
        gaps = {}
        for layer in self.layers:
            gaps.setdefault(layer["capacitor"], 0.0)
            gaps[layer["capacitor"]] += layer["thickness_mm"] / layer["relative_permittivity"]
        weight = self.by_layer([1 / layer["relative_permittivity"] / gaps[layer["capacitor"]] ** 2
                                for layer in self.layers])
        return -field[1].dx(1) * weight * self.r * self.dx

    def deformation(self, u):
        return ufl.as_matrix([[1 + u[0].dx(0), 0, u[0].dx(1)], [0, 1 + u[0] / self.r, 0],
                              [u[1].dx(0), 0, 1 + u[1].dx(1)]])

    def energy(self, u):
        young = np.array([layer["youngs_modulus_kPa"] for layer in self.layers])
        nu = np.array([layer["poisson_ratio"] for layer in self.layers])
        mu = self.by_layer(young / (2 * (1 + nu)))
        lame = self.by_layer(young * nu / ((1 + nu) * (1 - 2 * nu)))
        f = self.deformation(u)
        log = ufl.ln(ufl.det(f))
        return (mu / 2 * (ufl.inner(f, f) - 3 - 2 * log) + lame / 2 * log**2) * self.r * self.dx

    def prepare_change(self, pressure_kPa):
        """The same for the change at finite strain: None where a load step has no solution."""
        u, v = fem.Function(self.space), ufl.TestFunction(self.space)
        load = fem.Constant(self.grid, PETSc.ScalarType(0))
        facets = np.sort(mesh.locate_entities_boundary(self.grid, 1, self.is_top))
        tags = mesh.meshtags(self.grid, 1, facets, np.ones(len(facets), dtype=np.int32))
        ds = ufl.Measure("ds", domain=self.grid, subdomain_data=tags)
        forces = ufl.derivative(self.energy(u), u, v) + load * v[1] * self.r * ds(1)
        problem = fem.petsc.NonlinearProblem(forces, u, self.conditions())
        return lambda: self.change_fF(problem, u, load, pressure_kPa)

    def change_fF(self, problem, u, load, pressure_kPa):
        reached, step, slope = 0.0, 1 / LOAD_STEPS, 0.0
        while reached < 1:
            last, step = u.x.array.copy(), min(step, 1 - reached)
            load.value = pressure_kPa * (reached + step)
            u.x.array[:] = last + step * slope
            newton = newton_solver(problem)
            try:
                newton.solve(u)
            except RuntimeError:
                u.x.array[:], step = last, step / 2
                if step < LEAST_STEP:
                    return None
                continue
            finally:
                newton.krylov_solver.reset()  # frees the factors
            reached, slope = reached + step, (u.x.array - last) / step
        return self.capacitance_change_fF(u)

    def capacitance_change_fF(self, u):
        """Local parallel plates over the radius at rest: displacement of each face, by cell."""
        axial, dofs = self.space.sub(1).collapse()
        points, heights = axial.tabulate_dof_coordinates(), u.x.array[dofs]
        gauss, weights = np.polynomial.legendre.leggauss(self.degree + 4)

        def on_face(z):
            row = np.flatnonzero(np.isclose(points[:, 1], z, rtol=0, atol=1e-9 * self.faces[-1]))
            row = row[np.argsort(points[row, 0])]
            values = []
            for cell in range(len(self.radii) - 1):
                nodes = row[cell * self.degree:(cell + 1) * self.degree + 1]
                low, high = self.radii[cell:cell + 2]
                local = 2 * (points[nodes, 0] - low) / (high - low) - 1
                fit = np.polynomial.legendre.legfit(local, heights[nodes], self.degree)
                values.append(np.polynomial.legendre.legval(gauss, fit))
            return np.array(values)

        half = (self.radii[1:] - self.radii[:-1])[:, None] / 2
        rings = (self.radii[:-1, None] + half * (1 + gauss)) * half * weights
        gaps, closings, below = {}, {}, on_face(0.0)
        for layer, top in zip(self.layers, self.faces[1:]):
            above, which = on_face(top), layer["capacitor"]
            gaps[which] = gaps.get(which, 0) + layer["thickness_mm"] / layer["relative_permittivity"]
            closings[which] = (closings.get(which, 0)
                               + (below - above) / layer["relative_permittivity"])
            below = above
        changes = [closings[i] / (gaps[i] * (gaps[i] - closings[i])) for i in gaps]
        return 2 * np.pi * VACUUM_fF_mm * np.sum(rings * sum(changes))


def newton_solver(problem):
    """A new one for each load, because one that has met a NaN fails for ever."""
    newton = nls.petsc.NewtonSolver(MPI.COMM_SELF, problem)
    newton.convergence_criterion = "incremental"  # the residual of thin films is all rounding
    newton.max_it, newton.rtol, newton.atol = 30, 1e-9, 1e-10  # mm, over all nodes
    options, prefix = PETSc.Options(), newton.krylov_solver.getOptionsPrefix()
    for key, value in (("ksp_type", "preonly"), ("pc_type", "lu"),
                       ("pc_factor_mat_solver_type", "mumps"), ("mat_mumps_icntl_14", 100)):
        options[prefix + key] = value
    newton.krylov_solver.setFromOptions()
    return newton


def truths(stack, pressure_kPa):
    """Values and processor seconds by mesh (to assemble and to solve), and unknowns of the finest; None where the stack cannot
    be described."""
    finite = pressure_kPa is not None
    if not can_be_described(stack) or (finite and stack["top"] != "pressure"):
        return None
    studies = [Study(stack, *level) for level in (FINITE_LEVELS if finite else LEVELS)]
    unknowns = studies[-1].unknowns()
    if unknowns > (MOST_FINITE_UNKNOWNS if finite else MOST_UNKNOWNS):
        return None
    values, seconds = [], []
    for study in studies:
        solve = study.prepare_change(pressure_kPa) if finite else study.prepare_slope()
        began = time.process_time()
        values.append(solve())
        seconds.append(time.process_time() - began)
        if values[-1] is None:
            return None
    return values, seconds, unknowns


def main():
    pressure_kPa = float(sys.argv[1]) if len(sys.argv) > 1 else None
    what = "slope{}_fF_kPa" if pressure_kPa is None else f"change{{}}_fF_{pressure_kPa:g}kPa"
    columns = ["seed", "capacitors", "layers", "unknowns", "seconds"]
    columns += [what.format(i) for i in range(3)] + [f"seconds{i}" for i in range(3)]
    print(",".join(columns), flush=True)
    for line in sys.stdin:
        stack = json.loads(line)
        found = truths(stack, pressure_kPa)
        if found is None:
            continue
        values, seconds, unknowns = found
        count = len({layer["capacitor"] for layer in stack["layers"]})
        print(f"{stack['seed']},{count},{len(stack['layers'])},{unknowns},{sum(seconds):.1f},"
              + ",".join(f"{x:.10g}" for x in values) + ","
              + ",".join(f"{x:.3f}" for x in seconds), flush=True)


main()
