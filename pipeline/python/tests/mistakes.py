"""Calls that type checkers must refuse, a mistake on each line that says so; it is read, never run."""

from __future__ import annotations

import numpy as np

import softfish as sf

mesh = sf.Mesh.box((0.1, 0.01, 0.01), (10, 1, 1))
material = sf.Material(2e5, 0.45)
solver = sf.Solver.of_mesh(mesh, material, mesh.nodes[:, 0] == 0.0)
rest = solver.equilibrium(gravity=[0.0, 0.0, -9.81])
gradient = rest.adjoint(np.ones_like(rest.displacement))
model = solver.reduce([rest.displacement], 1)

sf.Mesh.box((0.1, 0.01, 0.01), (10, 1, 1), "cubic")  # mistake
sf.Mesh.read("body.msh", "foot")  # mistake
sf.Mesh.read(3)  # mistake
sf.Material("soft", 0.45)  # mistake
sf.Material(2e5, 0.45, viscosity=1.0)  # mistake
sf.Solver(mesh)  # mistake
sf.Case(5)  # mistake
sf.Case("finger.toml").solver(threads="two")  # mistake
solver.equilibrium(load_steps=2.5)  # mistake
solver.equilibrium(presure=1e3)  # mistake
solver.equilibrium(tolerance="fine")  # mistake
solver.simulate(1.5, 1e-3)  # mistake
solver.simulate(3, 1e-3, scheme="rk4")  # mistake
solver.simulate(3, 1e-3, progress="bar")  # mistake
solver.torch("marker.tip", ["E"], colour=3)  # mistake
solver.torch("marker.tip", ["E"], max_iterations="many")  # mistake
solver.jax("marker.tip", ["E"], kept="all")  # mistake
solver.jax("marker.tip", ["pressure"], steps=5, scheme="rk4")  # mistake
print(rest.displacment)  # mistake
print(rest.output(0))  # mistake
rest.adjoint()  # mistake
rest.modes("six")  # mistake
print(solver.modes()[2])  # mistake
gradient.youngs_modulus = np.zeros(1)  # mistake
print(gradient.pressures.first)  # mistake
model.step(rest)  # mistake
model.jax_step(dt="1 ms")  # mistake
sf.track("film.mp4", find="two")  # mistake
sf.calibrate("board", columns=9)  # mistake
