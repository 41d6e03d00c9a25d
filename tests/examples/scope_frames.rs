//! How smoothly `sinew scope` runs in headless Chromium, and whether the driver notices: the built-in hexapod with all its
//! 18 channels shown, the same run first without and then with the scope.
//!
//! ```text
//! cargo run --release -p sinew-tests --example scope_frames -- [SECONDS] [PICTURE.png]
//! ```

use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::Value;
use sinew_ipc::{Client, CommandKind, LoopStats};
use sinew_tests::browser::Browser;
use sinew_tests::{Driver, Process, Rig, sinew};

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let seconds = args.get(1).map_or(20.0, |text| text.parse().expect("a number of seconds"));
    let rig = Rig::named(|name| {
        let hexapod =
            std::fs::read_to_string(sinew_tests::checkout().join("examples/hexapod.toml")).expect("it is there");
        hexapod.replacen("name = \"hexapod\"", &format!("name = \"{name}\""), 1)
    });
    let (_driver, client) = Driver::ready(&rig);
    let walking = AtomicBool::new(true);
    std::thread::scope(|threads| {
        threads.spawn(|| walk(&rig.client(), &walking));
        measure(&rig, &client, seconds, args.get(2));
        walking.store(false, Ordering::Relaxed);
    });
}

/// Moves every wire up and down, each in its own time, as a robot program would.
fn walk(client: &Client, on: &AtomicBool) {
    let started = Instant::now();
    while on.load(Ordering::Relaxed) {
        let at = started.elapsed().as_secs_f64();
        for channel in 0..client.channels().len() {
            let stroke = 0.35 + 0.3 * (1.2 * at + channel as f64).sin();
            let _ = client.command(channel as u32, CommandKind::Stroke, stroke, Duration::from_secs(1));
        }
        std::thread::sleep(Duration::from_millis(100));
    }
}

fn measure(rig: &Rig, client: &Client, seconds: f64, picture: Option<&String>) {
    std::thread::sleep(Duration::from_secs(5));
    let alone = during(client, seconds, || {});
    let mut scope = Process::start(Command::new(sinew()).args(["scope", "--rig", &rig.name]));
    scope.wait_for_word("http://");
    let url = scope.stdout().trim().to_owned();
    let mut browser = Browser::start(1440, 900).expect("this measures a browser");
    browser.open(&url);
    browser.wait("page.curves && page.curves.length > 100");
    browser.eval("page.shown.size < page.names.length ? $('all').click() : 0");
    browser.wait("page.curves.series >= 36 && scope.statistics().bins > 5000");
    browser.eval("scope.restart()");
    let mut statistics = Value::Null;
    let watched = during(client, seconds, || statistics = browser.eval("scope.statistics()"));
    if let Some(path) = picture {
        browser.picture(path.as_ref());
    }
    println!("page: {statistics:#}");
    for (name, stats) in [("without the scope", alone), ("with the scope", watched)] {
        println!("{name}: {stats}");
    }
}

/// The loop's figures over so many seconds from now, at the end of which `look` is called.
fn during(client: &Client, seconds: f64, look: impl FnOnce()) -> String {
    let before = client.loop_stats();
    std::thread::sleep(Duration::from_secs_f64(seconds));
    look();
    let after = client.loop_stats();
    let us = |of: fn(&LoopStats) -> &sinew_ipc::Histogram, q: f64| {
        let (before, after) = (of(&before), of(&after));
        let counts = |h: &sinew_ipc::Histogram| h.filled().map(|(_, last, n)| (last, n)).collect::<Vec<_>>();
        let earlier: std::collections::BTreeMap<u64, u64> = counts(before).into_iter().collect();
        let new: Vec<(u64, u64)> =
            counts(after).into_iter().map(|(last, n)| (last, n - earlier.get(&last).copied().unwrap_or(0))).collect();
        let total: u64 = new.iter().map(|(_, n)| n).sum();
        let mut seen = 0;
        let at = new.iter().find(|(_, n)| {
            seen += n;
            seen as f64 >= q * total as f64
        });
        at.map_or(0.0, |(last, _)| *last as f64 * 1e-3)
    };
    format!(
        "{} cycles, {} missed; lateness p50 {:.1} µs, p99 {:.1} µs; cycle p50 {:.1} µs, p99 {:.1} µs",
        after.cycles - before.cycles,
        after.missed - before.missed,
        us(|s| &s.lateness, 0.5),
        us(|s| &s.lateness, 0.99),
        us(|s| &s.cycle_time, 0.5),
        us(|s| &s.cycle_time, 0.99),
    )
}
