//! Looking: at a running driver in a browser, at recordings in figures.

use std::net::{IpAddr, SocketAddr};
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::{Target, seconds};

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

/// `sinew plot`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  sinew plot walk.mcap -o walk.svg                       the usual quantities of the first channels over time
  sinew plot walk.mcap -o walk.html --channel front_left_femur --kind all
  sinew plot before.mcap after.mcap -o both.png --channel front_left_femur --quantity length --from 2 --to 6
  sinew plot furnace.csv.gz -o loop.png --kind hysteresis
  sinew plot walk.mcap -o phase.svg --kind phase --channel front_left_femur

Recordings are sessions (MCAP) and CSV files with the contract's columns; several are drawn over one another. The file's
ending says what it becomes: .svg, .png, or .html, a page to zoom into that needs no network.
Times are seconds from the start of each recording.")]
pub struct Plot {
    /// Recordings.
    #[arg(required = true, value_name = "RECORDING")]
    pub recordings: Vec<PathBuf>,
    /// Where the figure goes.
    #[arg(short, long, value_name = "FIGURE")]
    pub output: PathBuf,
    /// What kinds of figure; `all` takes whatever the recordings have.
    #[arg(long, value_name = "KIND", value_enum, default_value = "time")]
    pub kind: Vec<PlotKind>,
    /// Only these channels; otherwise the first six.
    #[arg(long, value_name = "NAME")]
    pub channel: Vec<String>,
    /// Only these quantities over time, with or without their unit.
    #[arg(long, value_name = "NAME")]
    pub quantity: Vec<String>,
    /// From this time, s.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// To this time, s.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Title; otherwise the recordings' names.
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Pass over columns of CSV that the contract does not know.
    #[arg(long)]
    pub ignore_columns: bool,
}

/// Kinds of figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PlotKind {
    /// Quantities over time.
    Time,
    /// Length against temperature.
    Hysteresis,
    /// Resistance against length.
    Resistance,
    /// Tension against length.
    Tension,
    /// Speed over control error, and the sliding surface.
    Phase,
    /// Histograms of how late the loop was woken and how long its cycles took.
    Lateness,
    /// All of these that the recordings have.
    All,
}
