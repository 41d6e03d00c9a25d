//! `sinew plot`: recordings become figures, and what cannot be drawn is said with the remedy.

use std::fs;

use crate::support::Scratch;

/// A furnace experiment: four columns over two minutes, one cell missing.
fn furnace(scratch: &Scratch, name: &str, scale: f64) {
    let mut text = String::from("time_s,temperature_c,position_m,force_n\n");
    for i in 0..1200 {
        let t = f64::from(i) * 0.1;
        let phase = t / 20.0;
        let position = if i == 600 { String::new() } else { format!("{}", scale * (0.004 - 0.003 * phase.sin())) };
        text += &format!("{t:.1},{:.2},{position},1.2\n", 60.0 + 40.0 * (phase - 0.4).sin());
    }
    scratch.file(name, text);
}

#[test]
fn recordings_become_pictures_and_pages() {
    let scratch = Scratch::new();
    furnace(&scratch, "one.csv", 1.0);
    furnace(&scratch, "two.csv", 1.5);
    scratch.sinew(["plot", "one.csv", "-o", "time.svg"]).done();
    let svg = fs::read_to_string(scratch.path("time.svg")).unwrap();
    for title in [">one<", ">Elongation, mm<", ">Tension, N<", ">Wire temperature, °C<", "\nTime, s\n"] {
        assert!(svg.contains(title), "{title}");
    }
    scratch.sinew(["plot", "one.csv", "two.csv", "-o", "loop.png", "--kind", "hysteresis"]).done();
    assert!(fs::read(scratch.path("loop.png")).unwrap().starts_with(b"\x89PNG\r\n"));
    scratch.sinew(["plot", "one.csv", "two.csv", "-o", "both.html", "--kind", "all", "--title", "A & B"]).done();
    let page = fs::read_to_string(scratch.path("both.html")).unwrap();
    assert!(
        page.contains("<title>A &amp; B</title>") && page.contains("\"kind\":\"hysteresis\"") && page.contains("uPlot")
    );
    assert!(!page.contains("\"kind\":\"phase\""), "there is no target in it");
    scratch.sinew(["plot", "one.csv", "-o", "part.svg", "--quantity", "position", "--from", "10", "--to", "20"]).done();
    let part = fs::read_to_string(scratch.path("part.svg")).unwrap();
    assert!(part.contains("Elongation") && !part.contains("Tension") && part.len() < svg.len());
}

#[test]
fn what_cannot_be_drawn_is_said() {
    let scratch = Scratch::new();
    furnace(&scratch, "one.csv", 1.0);
    let plot = |args: &[&'static str]| scratch.sinew(["plot"].into_iter().chain(args.iter().copied()));
    plot(&["one.csv", "-o", "figure.pdf"]).refused(&["figure.pdf", ".svg, .png or .html"]);
    plot(&["none.csv", "-o", "figure.svg"]).refused(&["none.csv"]);
    plot(&["one.csv", "-o", "no/figure.svg"]).refused(&["mkdir -p no"]);
    plot(&["one.csv", "-o", "f.svg", "--kind", "phase"]).refused(&["phase", "targets", "session"]);
    plot(&["one.csv", "-o", "f.svg", "--kind", "lateness"]).refused(&["lateness", "sinew record"]);
    plot(&["one.csv", "-o", "f.svg", "--channel", "knee"]).refused(&["\"knee\"", "one"]);
    plot(&["one.csv", "-o", "f.svg", "--quantity", "speed"]).refused(&["\"speed\"", "force_n"]);
    plot(&["one.csv", "-o", "f.svg", "--from", "5", "--to", "2"]).refused(&["5 to 2 s"]);
    plot(&["one.csv", "-o", "f.svg", "--from", "500"]).refused(&["nothing to draw", "--from"]);
    assert!(!scratch.path("f.svg").exists());
    scratch.file("not.mcap", b"\x89MCAP0\r\nand nothing else");
    plot(&["not.mcap", "-o", "f.svg"]).refused(&["not.mcap"]);
}
