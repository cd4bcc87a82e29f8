//! Claims about the physics and the mathematics of the plant.
//!
//! | claim | oracle | module |
//! |---|---|---|
//! | D symmetric and positive definite, the energy of the point masses of a body | Cholesky; complex step of positions | `equations` |
//! | Ḋ − 2C skew, `C Q̇` that of Lagrange, g the gradient | differences of eighth order | `equations` |
//! | D, `C Q̇`, g, tau, accelerations, tensions | sympy, and Newton and Euler in its generator, in a golden file | `golden` |
//! | tau the virtual work of all fluid forces | points moved by complex step | `equations` |
//! | energy, its balance with fluid and winches, dissipation, Jacobi integral in a flow | quadrature along flights | `energy` |
//! | angular momentum about the vertical, also while reeling | conservation | `energy` |
//! | turned, mirrored, carried along | symmetry | `symmetry` |
//! | pendulum small and large, cone, constant side force, reeling, free tops, roll pendulum | closed forms, AGM | `limits` |
//! | trim: residual, drift over 100 s, closed form of a sphere, every reason for none | closed forms, second description | `trims`, `limits` |
//! | tensions: sum, virtual work, moments at the attachments; time of slack | closed forms | `lines` |
//! | linearization and modes | differences, response to a kick, an independent program's golden file, matrices with known modes | `linearization`, `eigenmodes` |
//! | stall, parity, no flow, flow from behind, build-up, tether drag | definitions in vectors, closed forms, fine quadrature | `aerodynamics` |
//! | sine, cosine, arc tangent; lanes bit for bit | the platform's functions | `scalars` |
//! | sides that differ: all terms of (4), trims; mirror, symmetric limit, point masses, signs | sympy, a root search on Newton and Euler; closed forms | `asymmetry` |
//! | water that moves beside its flow | another flow; virtual work of points moved by complex step | `disturbance` |
//! | ballast and fins with mass | sums over point masses by numpy; parallel axes | `ballast` |
//! | bad numbers, Phi = 0, V = 0 | errors by name, value and time | `inputs`, `trims`, `flows` |
//! | random plants stay finite and gain no energy in still fluid | sign | `fuzz` |
//!
//! Not here, and why: a moving frame (the winches do not move; `symmetry` has what remains of it), formulas for rings, fins
//! and added mass (the crate has none: coefficients are parameters), the order of an integrator and the steps of a profile
//! (the crate integrates nothing).

#![expect(clippy::float_cmp, reason = "bit-for-bit claims compare numbers with ==")]
#![expect(clippy::unwrap_used, reason = "the helpers of tests fail like tests")]

mod aerodynamics;
mod asymmetry;
mod ballast;
mod disturbance;
mod eigenmodes;
mod energy;
mod equations;
mod flows;
mod fuzz;
mod golden;
mod inputs;
mod limits;
mod linearization;
mod lines;
mod oracle;
mod plants;
mod scalars;
mod symmetry;
mod trims;
