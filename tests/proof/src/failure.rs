//! Why a run ends without its answer.

use std::error::Error;

/// Any error that may cross threads.
pub type Failure = Box<dyn Error + Send + Sync>;
