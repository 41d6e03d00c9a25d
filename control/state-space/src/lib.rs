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
//! ```
//! use sinew_state_space::riccati::lqr;
//! use sinew_state_space::{DMatrix, eigenvalues};
//!
//! // A mass of 1 kg on nothing, pushed by a force: the gain that brings its position back.
//! let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
//! let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
//! let k = lqr(&a, &b, &DMatrix::identity(2, 2), &DMatrix::identity(1, 1))?;
//! assert!((k[0] - 1.0).abs() < 1e-9 && (k[1] - 3f64.sqrt()).abs() < 1e-9);
//! // u = −K x makes the loop stable.
//! assert!(eigenvalues(&(&a - &b * &k))?.iter().all(|pole| pole.re < 0.0));
//! # Ok::<(), sinew_state_space::Error>(())
//! ```
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
