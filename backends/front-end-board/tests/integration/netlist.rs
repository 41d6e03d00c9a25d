//! `firmware/rp2040/board/board.net`, which the pictures of `docs/board.md` are drawn from, is the board of the firmware and of the page: by
//! its pins, its parts, and by what stands between the supply and a wire.

use std::collections::{BTreeMap, BTreeSet};

use sinew_front_end_board::{CHANNELS, pico};

const NETLIST: &str = include_str!("../../../../firmware/rp2040/board/board.net");
const PAGE: &str = include_str!("../../../../docs/board.md");

struct Part {
    reference: String,
    kind: String,
    value: String,
    /// Net by pin.
    pins: BTreeMap<String, String>,
}

impl Part {
    /// The ends between which current can flow, at the most: a switch that is on, a contact that is closed.
    fn carries(&self) -> Option<[&str; 2]> {
        let ends = match self.kind.as_str() {
            "fuse" | "nc" | "ferrite" => ["1", "2"],
            "pmos" => ["S", "D"],
            "wire" => ["moving", "fixed"],
            _ => return None,
        };
        Some(ends.map(|end| self.pins[end].as_str()))
    }
}

/// All parts, those of each wire for each.
fn parts() -> Vec<Part> {
    let lines = NETLIST.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let mut parts = Vec::new();
    for line in lines.filter(|line| !line.starts_with("sheet ")) {
        let of_each = if line.contains('{') { 0..CHANNELS } else { 0..1 };
        for k in of_each {
            let line = [("{k}", k), ("{k+1}", k + 1), ("{k+2}", k + 2), ("{2k}", 2 * k), ("{2k+1}", 2 * k + 1)]
                .iter()
                .fold(line.to_string(), |line, (form, number)| line.replace(form, &number.to_string()));
            let mut words = line.split_whitespace();
            let mut next = || words.next().unwrap_or_else(|| panic!("{line}: reference, part, value")).to_string();
            let (reference, kind, value) = (next(), next(), next());
            let pin = |word: &str| {
                let (pin, net) = word.split_once('=').unwrap_or_else(|| panic!("{line}: {word} is no PIN=NET"));
                (pin.to_string(), net.to_string())
            };
            parts.push(Part { reference, kind, value, pins: words.map(pin).collect() });
        }
    }
    parts
}

/// Nets that carry current from `from` with some parts taken out.
fn reached<'a>(parts: &'a [Part], from: &'a str, without: &str) -> BTreeSet<&'a str> {
    let mut reached = BTreeSet::from([from]);
    loop {
        let more: Vec<&str> = parts
            .iter()
            .filter(|part| part.reference != without)
            .filter_map(Part::carries)
            .filter(|ends| {
                ends.iter().any(|end| reached.contains(end)) && !ends.iter().all(|end| reached.contains(end))
            })
            .flatten()
            .collect();
        if more.is_empty() {
            return reached;
        }
        reached.extend(more);
    }
}

fn named<'a>(parts: &'a [Part], reference: &str) -> &'a Part {
    parts.iter().find(|part| part.reference == reference).unwrap_or_else(|| panic!("there is no {reference}"))
}

/// Whether a resistor of this value lies between two nets.
fn lies_between(parts: &[Part], value: &str, one: &str, other: &str) -> bool {
    let ends = |part: &Part| [part.pins["1"].clone(), part.pins["2"].clone()];
    let mut resistors = parts.iter().filter(|part| part.kind == "r" && part.value == value);
    resistors.any(|part| ends(part) == [one, other] || ends(part) == [other, one])
}

#[test]
fn every_part_is_there_once_and_no_pin_hangs_in_the_air() {
    let parts = parts();
    let references: BTreeSet<&str> = parts.iter().map(|part| part.reference.as_str()).collect();
    assert_eq!(references.len(), parts.len(), "a reference twice");
    let mut pins_on: BTreeMap<&str, usize> = BTreeMap::new();
    parts.iter().flat_map(|part| part.pins.values()).for_each(|net| *pins_on.entry(net).or_default() += 1);
    let alone: Vec<_> = pins_on.iter().filter(|(_, count)| **count < 2).collect();
    assert!(alone.is_empty(), "nets with one pin: {alone:?}");
}

#[test]
fn pins_are_the_firmwares_and_held_as_the_table_says() {
    let parts = parts();
    let pico = named(&parts, "U1");
    let used: BTreeSet<u8> =
        pico.pins.keys().filter_map(|pin| pin.strip_prefix("GP")).map(|n| n.parse().expect("a number")).collect();
    // the light is the Pico's own
    assert_eq!(used, pico::TABLE.iter().map(|(pin, ..)| *pin).filter(|pin| *pin != pico::LED).collect());
    for (pin, name, held) in pico::TABLE.iter().filter(|(pin, ..)| *pin != pico::LED) {
        let net = &pico.pins[&format!("GP{pin}")];
        let to = |other| lies_between(&parts, "10k", net, other);
        assert_eq!(to("gnd"), held.starts_with("10 kΩ to ground") || *pin == pico::SUPPLY, "GP{pin}, {name}");
        assert_eq!(to("3V3"), held.starts_with("10 kΩ to 3.3 V"), "GP{pin}, {name}");
    }
    let converter = named(&parts, "U2");
    let expected = [
        ("CONVST", pico::CONVST),
        ("BUSY", pico::BUSY),
        ("RESET", pico::ADC_RESET),
        ("SDOA", pico::SDOA),
        ("CS", pico::CS),
        ("SCLK", pico::SCLK),
        ("SDI", pico::SDI),
    ];
    for (pin, gp) in expected {
        assert_eq!(converter.pins[pin], pico.pins[&format!("GP{gp}")], "{pin}");
    }
    for (k, gate) in pico::GATES.iter().enumerate() {
        assert_eq!(named(&parts, &format!("Q6.{k}")).pins["G"], format!("GP{gate}"));
    }
    assert_eq!(named(&parts, "Q6").pins["G"], format!("GP{}", pico::ENABLE));
    assert_eq!(named(&parts, "SW1b").pins["1"], format!("GP{}", pico::STOP));
    assert_eq!(named(&parts, "SW2").pins["1"], format!("GP{}", pico::STOP_RESET));
}

/// V2 and V3 of a wire are a pair that is sampled in one instant, and so are V1 and the shunt.
#[test]
fn inputs_are_those_that_the_page_says() {
    let parts = parts();
    let converter = named(&parts, "U2");
    for k in 0..CHANNELS {
        let wire = named(&parts, &format!("W.{k}"));
        for (end, pin) in [
            ("tap2", format!("V{}A", 2 * k)),
            ("moving", format!("V{}B", 2 * k)),
            ("tap1", format!("V{}A", 2 * k + 1)),
            ("fixed", format!("V{}B", 2 * k + 1)),
        ] {
            assert!(lies_between(&parts, "1k", &wire.pins[end], &converter.pins[&pin]), "wire {k}: {end} at {pin}");
        }
        assert!(lies_between(&parts, "0.5", &wire.pins["fixed"], "gnd"), "wire {k}: its shunt");
    }
}

/// Each of these alone leaves every wire without current, and a wire's own leave the others theirs.
#[test]
fn what_stands_between_the_supply_and_a_wire_switches_it_off() {
    let parts = parts();
    let moving = |k: usize| named(&parts, &format!("W.{k}")).pins["moving"].as_str();
    let heated = |without: &str| {
        let reached = reached(&parts, "supply", without);
        (0..CHANNELS).filter(|k| reached.contains(moving(*k))).collect::<Vec<_>>()
    };
    assert_eq!(heated(""), [0, 1, 2, 3], "with everything on");
    for (part, says) in [("F5", "its fuse"), ("SW1a", "the emergency stop"), ("Q5", "the master switch")] {
        assert_eq!(heated(part), [] as [usize; 0], "{says}");
    }
    for k in 0..CHANNELS {
        let others: Vec<usize> = (0..CHANNELS).filter(|other| *other != k).collect();
        for part in [format!("F{}", k + 1), format!("Q{}", k + 1)] {
            assert_eq!(heated(&part), others, "{part}");
        }
    }
}

/// With nobody at the gates: each is held at its source, and what would pull it away is held off.
#[test]
fn without_a_signal_every_switch_is_off() {
    let parts = parts();
    let mut switches = 0;
    for part in parts.iter().filter(|part| part.kind == "pmos") {
        assert!(lies_between(&parts, "1k", &part.pins["S"], &part.pins["G"]), "{}", part.reference);
        let driver = parts.iter().find(|other| other.kind == "nmos" && other.pins["D"] == part.pins["G"]);
        let driver = driver.unwrap_or_else(|| panic!("{} has no driver", part.reference));
        assert_eq!(driver.pins["S"], "gnd");
        assert!(lies_between(&parts, "10k", &driver.pins["G"], "gnd"), "{}", driver.reference);
        switches += 1;
    }
    assert_eq!(switches, CHANNELS + 1);
}

#[test]
fn the_page_counts_its_parts() {
    let parts = parts();
    let count = |is: &dyn Fn(&Part) -> bool| parts.iter().filter(|part| is(part)).count();
    let of = |value: &str| count(&|part| part.value == value);
    let inputs = count(&|part| part.value == "1k" && part.pins["2"].starts_with(['A', 'B']));
    for (row, counted) in [
        ("| Raspberry Pi Pico |", of("Pico").to_string()),
        ("| AD7616BSTZ |", of("AD7616BSTZ").to_string()),
        ("| AO3401A or the like |", of("AO3401A").to_string()),
        ("| 2N7002 |", of("2N7002").to_string()),
        ("| 0.5 Ω, 1 %, 1 W (2512) |", of("0.5").to_string()),
        ("| 1 kΩ, 1 % |", format!("{inputs} + {}", of("1k") - inputs)),
        ("| 10 kΩ; 30 kΩ |", format!("{}; {}", of("10k"), of("30k"))),
        ("| fuses |", count(&|part| part.kind == "fuse").to_string()),
        ("| 470 µF, 16 V |", of("470µ").to_string()),
        ("| 10 µF; ferrite, 600 Ω at 100 MHz |", format!("{}; {}", of("10µ"), count(&|part| part.kind == "ferrite"))),
    ] {
        let line =
            PAGE.lines().find(|line| line.starts_with(row)).unwrap_or_else(|| panic!("docs/board.md lacks {row}"));
        assert!(line.ends_with(&format!("| {counted} |")), "counted {counted}: {line}");
    }
}
