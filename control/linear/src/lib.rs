//! Linear systems in state space, ẋ = A x + B u, y = C x: what appendix A of the thesis reviews, as small functions on
//! [`nalgebra`] matrices.
//!
//! | module | what | section of appendix A (its equations carry no numbers) |
//! |---|---|---|
//! | [`convert`] | continuous ↔ discrete time, inputs and noise | Deterministic/Stochastic State-Space Models |
//! | [`derive`](mod@derive) | derivatives by the complex step | Linearization of Nonlinear State Equations |
//! | [`rank`] | controllability and observability | Controllability; Observability |
//! | [`place`] | gains that put the poles where they are wanted | State-Feedback Controller; State Estimator |
//! | [`riccati`] | optimal gains: LQR and its dual, both times | State-Feedback Controller; State Estimator |
//! | [`servo`] | the integral of the error as a state | Robust Servo Control |
//!
//! For small systems (up to some ten states) at construction time: everything here allocates. Feedback is u = −K x,
//! observers correct by +L (y − C x). Nothing panics; what cannot be answered is an [`Error`].
#![forbid(unsafe_code)]

mod balance;
pub mod convert;
pub mod derive;
mod error;
pub mod place;
pub mod rank;
pub mod riccati;
pub mod servo;
mod spectrum;

pub use error::Error;
pub use nalgebra::{Complex, DMatrix, DVector};
pub use spectrum::eigenvalues;
