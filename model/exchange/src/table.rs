//! What can be written as a file: cycles of channels, one after the other.

use sinew_recording::Error;
use sinew_recording::session::{About, Head, Layout, Session};

/// One cycle on its way into a file.
#[derive(Debug, Clone, Copy)]
pub struct Cycle<'a> {
    /// Number and time.
    pub head: Head,
    /// Time since the start of the recording, s.
    pub time_s: f64,
    /// The channels, as the layout says.
    pub bytes: &'a [u8],
}

/// Cycles of channels.
pub trait Table {
    /// Where they come from.
    fn about(&self) -> &About;

    /// Channels and fields.
    fn layout(&self) -> &Layout;

    /// Shows every cycle in order.
    ///
    /// # Errors
    /// Where they cannot be read on; whatever `see` gives back.
    fn each(&self, see: &mut dyn FnMut(&Cycle<'_>) -> Result<(), Error>) -> Result<(), Error>;

    /// About how many there are.
    fn count(&self) -> u64;
}

/// A session, or what lies between two times of it.
#[derive(Debug, Clone, Copy)]
pub struct SessionPart<'a> {
    /// The session.
    pub session: &'a Session,
    /// From this time, s since the start of the recording; −∞ = from its beginning.
    pub from_s: f64,
    /// Up to this time, without it, s; ∞ = to its end.
    pub to_s: f64,
}

impl<'a> SessionPart<'a> {
    /// All of a session.
    pub fn whole(session: &'a Session) -> SessionPart<'a> {
        SessionPart { session, from_s: f64::NEG_INFINITY, to_s: f64::INFINITY }
    }
}

impl Table for SessionPart<'_> {
    fn about(&self) -> &About {
        self.session.about()
    }

    fn layout(&self) -> &Layout {
        self.session.layout()
    }

    fn each(&self, see: &mut dyn FnMut(&Cycle<'_>) -> Result<(), Error>) -> Result<(), Error> {
        let mut cycles = self.session.cycles_between(self.from_s, self.to_s);
        while let Some(view) = cycles.next()? {
            let time_s = self.session.time_s(&view.head);
            see(&Cycle { head: view.head, time_s, bytes: view.bytes() })?;
        }
        Ok(())
    }

    fn count(&self) -> u64 {
        self.session.cycle_count()
    }
}
