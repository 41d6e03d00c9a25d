//! Sensing, estimators and controllers on the same simulated plants, beside what physics allows.
#![forbid(unsafe_code)]
