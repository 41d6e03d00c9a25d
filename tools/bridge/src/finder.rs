//! Finds the driver of a rig, and finds it again after a restart.

use std::sync::Arc;
use std::time::Duration;

use sinew_ipc::{Client, ClientOptions, DriverHealth, Error};

/// Finds the driver of a rig.
pub struct Finder {
    rig: String,
    client: Option<Arc<Client>>,
    /// Why there was none, when it was last looked for: said once.
    said: String,
}

impl Finder {
    /// Of the rig with this name, without having looked.
    ///
    /// # Errors
    /// [`Error::RigName`].
    pub fn new(rig: &str) -> Result<Finder, Error> {
        sinew_ipc::check_rig_name(rig)?;
        Ok(Finder { rig: rig.into(), client: None, said: String::new() })
    }

    /// The driver that runs now, also one that stands still; never waits.
    pub fn find(&mut self) -> Option<Arc<Client>> {
        if self.client.as_ref().is_some_and(|client| has_ended(client)) {
            self.client = None;
        }
        if self.client.is_none() {
            let options = ClientOptions { connect: Duration::ZERO, ..ClientOptions::default() };
            let found = Client::connect_with(&self.rig, options).map(Arc::new);
            let said = match &found {
                Ok(client) => format!("the driver of {} runs as process {}", self.rig, client.info().pid),
                Err(error) => error.message(),
            };
            if said != self.said {
                tracing::info!("{said}");
                self.said = said;
            }
            self.client = found.ok().filter(|client| !has_ended(client));
        }
        self.client.clone()
    }
}

/// Whether nothing new comes from this driver any more.
pub fn has_ended(client: &Client) -> bool {
    matches!(client.health(), DriverHealth::Stopped | DriverHealth::Died)
}
