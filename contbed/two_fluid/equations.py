"""The two-fluid model of gas and particles with the kinetic theory of granular flow.

    d eps_s/dt + div(eps_s u_s) = 0,   eps_g = 1 - eps_s,   div(eps_g u_g + eps_s u_s) = 0
    eps_g rho_g D u_g/dt = -eps_g grad p + div tau_g - beta (u_g - u_s) + eps_g rho_g g
    eps_s rho_s D u_s/dt = -eps_s grad p - grad p_s + div tau_s + beta (u_g - u_s) + eps_s rho_s g
    3/2 rho_s eps_s D theta/dt = -p_s div u_s + tau_s : grad u_s + div(k grad theta) - gamma - 3 beta theta

    eps_s, eps_g [-]      fractions of solids and gas             u_s, u_g [m/s]     intrinsic velocities
    p [Pa]                pressure of the gas                     theta [m2/s2]      granular temperature
    beta [kg/m3/s]        drag coefficient                        tau [Pa]           mu (grad u + grad u^T) + ... I
    p_s [Pa]              solids pressure                         k [kg/m/s]         granular conductivity
    gamma [W/m3]          dissipation by collisions               g [m/s2]           gravity

with p_s = rho_s eps_s theta (1 + 2 (1 + e) eps_s g0) and friction near packing
(Gidaspow 1994, Multiphase Flow and Fluidization, Academic Press). Heat is in
heat/equations.py, that of walls in heat/wall_layer.py.

Discretization: cell-centred finite volumes on any mesh, collocated. One step (step.py)
is a projection method, in this order: continuity.advance, heat/equations.advance,
properties.evaluate_closures, momentum.predict, pressure.project (face_velocities.py,
pressure_equation.py), momentum.reconstruct (cell_velocities.py),
granular_temperature.advance. `model.kernels.NAME` is the function NAME of these files,
or of rectangular/ on large grids of rectangles.

Solids move with one limited volume flux; both velocities are convected (MUSCL,
explicit) and sheared (implicit); forces and partially eliminated drag act on faces, and
one pressure equation makes the flux of both phases free of divergence; cell velocities
are reconstructed from the faces. Drag, solids pressure, stress and granular temperature
are implicit. The step is bound by the Courant number of the particles and by the heat
of compression and shear; faster gas is sub-cycled.
"""
