//! The backend interface: the contract between the loop and the hardware that powers and measures the wires.
//!
//! Only the backend knows the hardware: a power stage with converters, or a simulated rig. The
//! loop uses a few calls of [`Backend`], in one fixed order:
//!
//! ```text
//! start() -> ( is_due()* -> missed(n)? -> exchange(duty, samples) )* -> stop()
//! ```
//!
//! **Timing.** [`Backend::exchange`] is called once a period, from the real-time thread. It passes the duty of the
//! period that begins now and returns the samples of the on-phase of the last period. It must return well
//! within the period (aim at a tenth of it), in a time that does not grow with run length, and must neither allocate,
//! lock, log nor unwind. The only system calls allowed in it are the ones its hardware needs.
//!
//! **Ranges.** Duty is finite and in 0 ..= 1, one for each channel in the rig's order; the driver guarantees it and a
//! backend checks it anyway. Samples are SI; a value not sampled is NaN, never a stale or invented number. With duty 0
//! there is no on-phase, so voltages and current are NaN (or the converter's real readings). Where one input is shared
//! (`circuit = "shared"` in the rig file), V3 is NaN, the supply is that input's reading in the off-phase of the same
//! period (NaN where duty 1 leaves none), the current is its reading in the on-phase, over shunt and switch.
//!
//! **Dark periods.** With duty 0 a backend samples nevertheless if it can, with the gate closed: only a current there shows
//! a power stage that conducts by itself (the driver's `stage`). A backend that cannot sample then leaves NaN, and reports such a
//! stage as [`ChannelFault::Stage`] if its hardware detects it.
//!
//! **Zero.** Outputs are zero after [`Backend::start`], after [`Backend::stop`], after a failed `exchange` and after drop; where one has
//! not confirmed that, [`Backend::is_confirmed`] and [`Zero`] say so. `start` fails where it does not get that confirmed.
//!
//! **Silence.** A driver may die with any duty put out. [`Backend::silence_s`] says how long that lasts then; the driver puts no duty out
//! that would overheat its wire in that time, and refuses a backend that cannot say.
//!
//! **Past.** Wires outlive drivers. Where [`Backend::output_name`] names an output, the driver keeps a record of its wire's heat, and believes it
//! at the next start only if [`Backend::past`] shows the [`Backend::mark`] it carries: else somebody else may have used the output since.
//!
//! **Supply.** Where there is a line that switches the supply of all stages (`[backend.enable]`), it is off before the first exchange and
//! after `stop`, at the backend's end on whichever way, and while it is [cut](Backend::cut). What an emergency stop shows
//! ([`Backend::stop_inputs`]) is latched by the driver alone.
//!
//! # Example: a minimal backend
//! The smallest that fulfils the contract: one channel, a resistor of 10 Ω at 6 V that is sampled by the exchange itself.
//!
//! ```
//! use sinew_backend::{Backend, BackendError, Sample, Zero, check_exchange};
//!
//! struct Resistor {
//!     is_on: bool,
//!     duty: f64,
//! }
//!
//! impl Backend for Resistor {
//!     fn channels(&self) -> usize {
//!         1
//!     }
//!     fn start(&mut self) -> Result<(), BackendError> {
//!         (self.is_on, self.duty) = (true, 0.0);
//!         Ok(())
//!     }
//!     fn exchange(&mut self, duty: &[f64], samples: &mut [Sample]) -> Result<(), BackendError> {
//!         let checked = if self.is_on { check_exchange(1, duty, samples) } else { Err(BackendError::NotStarted) };
//!         if let Err(error) = checked {
//!             samples.fill(Sample::NONE);
//!             self.duty = 0.0;
//!             return Err(error);
//!         }
//!         samples[0] = Sample { supply_v: 6.0, ..Sample::NONE };
//!         if self.duty > 0.0 {
//!             samples[0] = Sample { v1_v: 6.0, v2_v: 3.0, v3_v: 0.0, current_a: 0.6, supply_v: 6.0 };
//!         }
//!         self.duty = duty[0];
//!         Ok(())
//!     }
//!     fn silence_s(&self) -> Option<f64> {
//!         Some(0.0) // nothing here outlives the driver
//!     }
//!     fn stop(&mut self) -> Zero {
//!         (self.is_on, self.duty) = (false, 0.0);
//!         Zero::Confirmed
//!     }
//! }
//!
//! let mut resistor = Resistor { is_on: false, duty: 0.0 };
//! let mut samples = [Sample::NONE];
//! resistor.start()?;
//! resistor.exchange(&[0.5], &mut samples)?;
//! assert!(samples[0].current_a.is_nan(), "nothing was driven before the first exchange");
//! resistor.exchange(&[0.5], &mut samples)?;
//! assert_eq!(samples[0].current_a, 0.6);
//! # Ok::<(), BackendError>(())
//! ```
#![deny(unsafe_code)]

#[allow(unsafe_code)]
pub mod allocations;
mod backend;
#[allow(unsafe_code)]
pub mod clock;
pub mod conformance;
mod error;

pub use backend::{Backend, Past, StopInputs, Truth, Unused, Zero, check_exchange};
pub use error::{BackendError, ChannelFault};
pub use sinew_sensing::Sample;
