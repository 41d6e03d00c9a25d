//! Records a running driver: an ordinary client, which writes every cycle of all channels into files.
//!
//! [`Recorder::start`] connects a stream to two threads. One reads it: it copies every cycle out of shared memory into blocks, and
//! waits for the driver only. The other one compresses the blocks and writes them. Between the two is a buffer of
//! several seconds ([`Options::buffer_bytes`]), so that a disk stalled for that long loses nothing. Cycles that do not fit
//! are lost, counted, and listed in the file ([`sinew_recording::session::Ending`]).
//!
//! Data are synced to the disk every few seconds and at the end of each file, so that even when the power fails only the last
//! seconds are missing. A recorder that is killed leaves every chunk it had completed, which is all but the last second.
//!
//! It ends before the disk is full ([`Options::keep_free_bytes`]), and keeps only the newest files where it is asked to
//! ([`Options::keep_files`], [`Options::keep_bytes`]).
//!
//! # Example
//! Ten seconds of a running driver into one file:
//!
//! ```no_run
//! use sinew_ipc::Client;
//! use sinew_recorder::{Options, Recorder};
//!
//! let options = Options { duration_s: Some(10.0), ..Options::new("walk.mcap") };
//! let recorder = Recorder::start(Client::connect("hexapod")?, options)?;
//! while recorder.is_running() {
//!     std::thread::sleep(std::time::Duration::from_millis(100));
//! }
//! let report = recorder.join();
//! println!("{} cycles, {} lost", report.cycles, report.lost);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The columns are the published fields of a channel, in the order of their bytes:
//!
//! ```
//! let layout = sinew_recorder::layout(vec!["knee".into()]).unwrap();
//! assert_eq!(layout.fields[0].name, "length_m");
//! assert_eq!(layout.fields.len(), sinew_ipc::ChannelState::FIELDS.len());
//! ```
#![forbid(unsafe_code)]

mod blocks;
mod drain;
mod error;
mod events;
mod figures;
mod files;
mod floor;
mod options;
mod recorder;
mod retention;
mod shared;
mod state;
mod warning;
mod writer;

pub use blocks::Block;
pub use error::Error;
pub use events::FaultEvents;
pub use figures::loop_figures;
pub use files::part_path;
pub use options::Options;
pub use recorder::{Live, Recorder, Report};
pub use shared::Removed;
pub use state::layout;
pub use warning::Warning;
