//! The arguments of `scope`.

use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;

use clap::Args;

use super::Target;
use crate::args::numbers::seconds;

/// `sinew scope`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew scope                          prints the page's address; open it in a browser of this machine
  sinew scope --port 8750 --rig hexapod
  sinew scope --no-commands            a page that only watches
  sinew scope --lan                    also on the network, for the phone beside the bench: HTTPS and a PIN
  ssh -L 8750:127.0.0.1:8750 robot     then `sinew scope --port 8750` there and the address here
  my-logger | sinew scope --stdin      no driver: whatever numbers a program prints
  sinew scope --serial /dev/ttyUSB0 --baud 9600 --names 'temp_C,force [N]'

A stream is lines of numbers, parted by tabs, semicolons, commas or blanks; a number may bear its name and unit (`force: 2.5 N`), \
a first line of words names the columns, and a first column called time or t with a unit of time is their clock.

The page listens on 127.0.0.1 only, unless --lan says otherwise. Whoever has the address may watch; commanding and recording take \
the token behind its #, which is new at every start. On the network nothing is shown before the PIN is typed that this terminal shows; \
the browser warns of a certificate that nobody vouches for: compare its fingerprint with the one printed here. Ctrl-C ends it.")]
pub struct Scope {
    /// Which driver.
    #[command(flatten)]
    pub target: Target,
    /// Show the numbers that are piped in, instead of a driver.
    #[arg(long, conflicts_with_all = ["serial", "name"])]
    pub stdin: bool,
    /// Show the numbers that a device prints on a serial line, instead of a driver.
    #[arg(long, value_name = "DEVICE", conflicts_with = "name")]
    pub serial: Option<String>,
    /// Rate of that line.
    #[arg(long, value_name = "BAUD", default_value_t = 115_200, requires = "serial")]
    pub baud: u32,
    /// Names of the numbers, in their order and with their units, where the stream has none.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub names: Vec<String>,
    /// Port of 127.0.0.1; 0 = any that is free.
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    pub port: u16,
    /// Also on the network, with HTTPS and a PIN, at this address of this machine; port 0 = any that is free. Without an address: at all of
    /// them, port 8751.
    #[arg(long, value_name = "ADDRESS[:PORT]", num_args = 0..=1, default_missing_value = "0.0.0.0", value_parser = lan_address)]
    pub lan: Option<SocketAddr>,
    /// Whoever has typed the PIN may command and record, too.
    #[arg(long, requires = "lan", conflicts_with = "no_commands")]
    pub lan_commands: bool,
    /// Folder for the recordings made by the page's button.
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub record_dir: PathBuf,
    /// Watch only: nobody may command or record through the page.
    #[arg(long)]
    pub no_commands: bool,
    /// Stop after so many seconds.
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
}

/// The port on the network unless another is asked for: always the same, since a browser's exception is for address and port.
const LAN_PORT: u16 = 8751;

/// An address to listen at, with its port or without.
fn lan_address(text: &str) -> Result<SocketAddr, String> {
    let address = text.parse().or_else(|_| text.parse::<IpAddr>().map(|address| (address, LAN_PORT).into()));
    address.map_err(|_| "an address of this machine is wanted, such as 192.168.1.20 or 192.168.1.20:8751".into())
}
