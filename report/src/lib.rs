//! The page and the ten lines: see [`sinew_diagnosis::Diagnosis`].
