//! Chapter 8: the test machine.

use sinew_physics::{Geometry, Inputs, Load, Wire, WireModel};
use sinew_plot::Ink;
use sinew_rig::{Machine, Rig};
use sinew_scope::{Came, Columns, Lines};

use super::amplifier;
use crate::chapter::Chapter::Eight;
use crate::chapter::Place::{Figure, Table};
use crate::found::Tried;
use crate::row::Row;
use crate::wires::{MPA, STEP_S, hanging, largest};

const MACHINE: &str = "model/rig/src/tables/machine.rs";

/// A rig with a machine that says nothing of itself.
const RIG: &str = "[rig]\nname = \"machine\"\nrate_hz = 80.0\n\n[machine]\n\n[[channel]]\nname = \"wire\"\n\n[channel.wire]\ndiameter_mm = 0.25\n\
                   length_mm = 300.0\n\n[channel.drive]\nkind = \"current\"\n\n[channel.load]\nkind = \"imposed_position\"\n";

fn machine() -> Tried<Machine> {
    Ok(Rig::parse(RIG, "the book's own rig")?.machine)
}

/// A second of a board's output: 500 numbers in rows of so many, printed in one of the ways in which boards print.
struct PrintedStream {
    rows: Vec<Vec<f64>>,
    text: String,
}

/// What boards print: from one number a row to fifty, with and without names, as a laboratory in Germany would have it too.
fn printed_streams() -> Vec<PrintedStream> {
    let plain = |by: &str, decimal: &str| {
        let (by, decimal) = (by.to_string(), decimal.to_string());
        move |row: &[f64]| row.iter().map(|n| n.to_string().replace('.', &decimal)).collect::<Vec<_>>().join(&by)
    };
    let named = |row: &[f64]| row.iter().enumerate().map(|(i, n)| format!("n{i}: {n}")).collect::<Vec<_>>().join(", ");
    type Print = dyn Fn(&[f64]) -> String;
    let ways: [Box<Print>; 5] = [
        Box::new(plain(" ", ".")),
        Box::new(plain(", ", ".")),
        Box::new(plain(";", ",")),
        Box::new(plain("\t", ".")),
        Box::new(named),
    ];
    let mut streams = Vec::new();
    for columns in [1, 2, 5, 10, 20, 50] {
        for (which, way) in ways.iter().enumerate() {
            // `1,5` alone on its line is two numbers wherever a comma parts numbers: nobody can tell
            if columns == 1 && which == 2 {
                continue;
            }
            let number = |i: usize| (0.37 * i as f64).sin() * 10f64.powi(i as i32 % 7 - 3);
            let rows: Vec<Vec<f64>> = (0..500 / columns)
                .map(|row| (0..columns).map(|column| number(row * columns + column)).collect())
                .collect();
            let text = rows.iter().map(|row| way(row) + "\r\n").collect();
            streams.push(PrintedStream { rows, text });
        }
    }
    streams
}

impl PrintedStream {
    /// How many of its numbers come back, when it comes in pieces as a serial line hands them over.
    fn read_back(&self) -> usize {
        let (mut lines, mut columns, mut rows) = (Lines::default(), Columns::default(), Vec::new());
        for piece in self.text.as_bytes().chunks(37) {
            lines.take(piece, |line| {
                if line.is_some_and(|line| matches!(columns.take(line), Came::Row | Came::Others)) {
                    rows.push(columns.row().to_vec());
                }
            });
        }
        self.rows
            .iter()
            .zip(&rows)
            .flat_map(|(sent, read)| sent.iter().zip(read))
            .filter(|(sent, read)| sent == read)
            .count()
    }
}

pub(crate) fn rows() -> Vec<Row> {
    let figure = |number, title, states| Row::new(Eight, Figure(number), title, states);
    vec![
        Row::new(
            Eight,
            Table(8),
            "what the machine was to do",
            "30 cm, 50 N, 25 cm/s, 20 Hz; 25 N are 400 MPa in 0.25 mm, and 2 Hz \
                at 2 cm take 25 cm/s.",
        )
        .code(MACHINE, "pub struct Machine")
        .differs(
            "400 MPa in 0.25 mm are 19.6 N; 25 N are 509 MPa. Table 9 then has \
                250 mm of travel, as the code does",
            |_, found| {
                let area = Geometry { diameter_m: 0.25e-3, length_m: 0.3 }.area_m2();
                found.near("400 MPa in 0.25 mm", "N", 25.0, 0.5, 400.0 * MPA * area);
                found.proof();
                found.near("stress of 25 N", "MPa", 509.3, 0.1, 25.0 / area / MPA);
                found.near("2 Hz at 2 cm", "cm/s", 25.0, 0.5, 100.0 * std::f64::consts::TAU * 2.0 * 0.02);
                let machine = machine()?;
                found.above("fastest cross-head", "m/s", 0.25, machine.max_speed_m_s);
                found.near("largest force", "N", 50.0, 1.0, machine.max_force_n);
                Ok(())
            },
        ),
        Row::new(
            Eight,
            Table(9),
            "what the machine was",
            "0.04 mm a step of an 8 mm screw, 0.625 µm a microstep, 0.75 g, 12 V, \
                0 to 95 °C.",
        )
        .code(MACHINE, "pub struct Machine")
        .differs(
            "400 steps of 0.04 mm are a screw of 16 mm, which is what the text \
                has; an 8 mm screw would step by 0.02 mm",
            |_, found| {
                let machine = machine()?;
                found.near(
                    "screw of 400 steps of 64 microsteps",
                    "mm",
                    8.0,
                    0.1,
                    400.0 * 64.0 * machine.microstep_m * 1e3,
                );
                found.proof();
                found.near("the same", "mm", 16.0, 1e-9, 400.0 * 64.0 * machine.microstep_m * 1e3);
                found.near("travel", "mm", 250.0, 1e-9, 1e3 * machine.travel_m);
                found.near("noise of the load cell", "g", 0.75, 0.001, machine.force_noise_n / 9.80665e-3);
                found.near("supply of the heater", "V", 12.0, 1e-9, machine.heater_supply_v);
                found.near("warmest chamber", "°C", 95.0, 1e-9, machine.chamber_max_c);
                Ok(())
            },
        ),
        figure(
            83,
            "the current amplifier",
            "PWM of 11 kHz (738 Hz by table 9) through 40 Hz to a smooth, regulated \
            current.",
        )
        .code("model/physics/src/params.rs", "pub struct Amplifier")
        .code("model/rig/src/tables/drive.rs", "full_current_a")
        .differs(
            "at table 9's 738 Hz a first-order low-pass of 40 Hz leaves a ripple of 17 % of \
            the current at half duty; 11 kHz is the one that is smooth, and what is \
            computed leaves its ripple out",
            amplifier::ripple,
        ),
        figure(
            84,
            "a plotter for any stream",
            "It draws and keeps whatever numbers come over a serial line, up to \
                500 a second.",
        )
        .code("tools/scope/src/stream.rs", "pub struct Stream")
        .code("tools/scope/src/stream/columns.rs", "pub struct Columns")
        .agrees(|_, found| {
            let streams = printed_streams();
            let printed: usize = streams.iter().map(|stream| stream.rows.len() * stream.rows[0].len()).sum();
            let read: usize = streams.iter().map(PrintedStream::read_back).sum();
            found.above("numbers a second that were printed", "1", 499.0, 500.0);
            found.equal("of them read again, by place and value", "1", 1.0, read as f64 / printed as f64);
            Ok(())
        }),
        figure(
            85,
            "a wire at seven powers",
            "Pulled by 12 mm and back at constant power: slack at little power, \
                superelastic at much.",
        )
        .code("model/physics/src/step/wire.rs", "pub fn step")
        .agrees(|_, found| {
            let model = WireModel {
                geometry: Geometry { diameter_m: 0.1e-3, length_m: 0.3 },
                load: Load::ImposedPosition,
                ..hanging()
            };
            let mut tight = Vec::new();
            for (i, power_w) in [0.1, 0.3, 0.5, 0.7, 0.9, 1.1, 1.3].into_iter().enumerate() {
                let inputs = |imposed: f64| Inputs { drive: power_w, imposed, ..model.rest_inputs() };
                let mut wire = Wire::with_inputs(&model, &inputs(0.0))?;
                let (mut x, mut force) = (Vec::new(), Vec::new());
                for k in 0..65_000 {
                    // 5 s to warm up, then twice 15 s up and 15 s down
                    let time = (f64::from(k) * STEP_S - 5.0).max(0.0) % 30.0;
                    let share = if time < 15.0 { time / 15.0 } else { 2.0 - time / 15.0 };
                    wire.step(&inputs(0.012 * share), STEP_S);
                    if k > 35_000 {
                        x.push(12.0 * share);
                        force.push(wire.tension_n());
                    }
                }
                // of the second way back, the share on which it pulls
                let back = &force[15_000..];
                tight.push(back.iter().filter(|n| **n > 0.01).count() as f64 / back.len() as f64);
                found.legend(Ink::Series(i as u8), &format!("{power_w} W"));
                found.line(("Displacement, mm", "1"), ("Load", "N"), Ink::Series(i as u8), (x, force));
            }
            found.below("share of the way back on which it pulls, 0.1 W", "1", 0.5, tight[0]);
            found.above("the same, 1.3 W", "1", 0.9, tight[6]);
            found.nothing(
                "it pulls no less with more power: largest fall",
                "1",
                0.01,
                largest(&tight.windows(2).map(|p| p[0] - p[1]).collect::<Vec<_>>()).max(0.0),
            );
            Ok(())
        }),
        figure(
            87,
            "PID and sliding mode on a coil spring",
            "PID rings, first-order sliding mode decays as its surface does.",
        )
        .not_given("the spring's wire, coil and turns, the gains and the surface's λ"),
        figure(88, "the same, everything measured", "The switch at 50 Hz shakes the machine.")
            .not_given("the same as of fig. 87"),
    ]
}
