//! The command line.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use clap::{Args as ClapArgs, Parser, Subcommand};

/// The running driver for Zenoh: its state and streams, and commands by whoever has a certificate for it.
#[derive(Debug, Parser)]
#[command(
    name = "sinew-zenoh",
    version,
    args_conflicts_with_subcommands = true,
    after_help = "\
Examples:
  sinew-zenoh                                          state and streams at tcp/127.0.0.1:7447
  sinew-zenoh --rig hexapod --rate 100                 a hundred cycles a second instead of all
  sinew-zenoh certificates keys anna --host robot      certificates of bridge and anna, in the folder keys
  sinew-zenoh --listen 0.0.0.0:7447 --certificates keys --commander anna
                                                       over QUIC (TLS 1.3); anna commands, others with a certificate look on

Keys are sinew/RIG/info, …/cycles, …/events, …/loop, …/channel/NAME, …/bridge and, for anna, …/commander/anna/command.
A process of its own; the driver has no port. It does not scout and listens at one address. Without --commander nothing that comes
over the network becomes a command. Ctrl-C ends it, and puts off what commanders hold."
)]
pub struct Args {
    /// Something else than to be a bridge.
    #[command(subcommand)]
    pub what: Option<What>,
    /// The bridge.
    #[command(flatten)]
    pub bridge: Bridge,
}

/// Something else than to be a bridge.
#[derive(Debug, Subcommand)]
pub enum What {
    /// Make certificates: of an authority and a bridge where there are none yet, and of clients.
    #[command(after_help = "\
Examples:
  sinew-zenoh certificates keys anna --host robot --host 192.0.2.7
  sinew-zenoh certificates keys bert                   another client, of the same authority

Of NAME, its machine gets authority.pem, NAME.pem and NAME.key; no other key leaves this one. authority.key is needed to make more
of them, and is best kept elsewhere.")]
    Certificates {
        /// Folder to make them in.
        folder: PathBuf,
        /// Clients; each may connect, and command where a bridge is started with `--commander NAME`.
        #[arg(value_name = "NAME")]
        names: Vec<String>,
        /// Name or address of the bridge's machine, besides localhost.
        #[arg(long = "host", value_name = "HOST")]
        hosts: Vec<String>,
    },
}

/// The bridge.
#[derive(Debug, ClapArgs)]
pub struct Bridge {
    /// Which driver; of a named rig it need not run yet.
    #[arg(long, value_name = "NAME")]
    pub rig: Option<String>,
    /// Where to listen. Other machines reach it only at an address of this machine's network.
    #[arg(long, value_name = "ADDRESS:PORT", default_value_t = SocketAddr::from((Ipv4Addr::LOCALHOST, 7447)))]
    pub listen: SocketAddr,
    /// Folder of `sinew-zenoh certificates`: links are QUIC, so TLS 1.3, and for those alone who have one.
    #[arg(long, value_name = "FOLDER")]
    pub certificates: Option<PathBuf>,
    /// Who may command, by the name of the certificate; may be given several times.
    #[arg(long = "commander", value_name = "NAME")]
    pub commanders: Vec<String>,
    /// At most so many cycles a second, Hz; otherwise every one.
    #[arg(long = "rate", value_name = "HZ", value_parser = positive, allow_negative_numbers = true)]
    pub rate_hz: Option<f64>,
    /// Stop after so many seconds.
    #[arg(long = "for", value_name = "SECONDS", value_parser = positive, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1e9 => Ok(value),
        _ => Err("give a number above 0".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory as _;
        Args::command().debug_assert();
    }

    #[test]
    fn numbers_are_above_zero_and_finite() {
        assert_eq!(positive("0.5"), Ok(0.5));
        for bad in ["0", "-1", "nan", "inf", "1e300", "ten"] {
            assert!(positive(bad).is_err(), "{bad}");
        }
    }
}
