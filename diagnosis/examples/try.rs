//! dev
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let rig = sinew_rig::Rig::load(std::path::Path::new(&a[1])).unwrap();
    let recs: Vec<_> = a[2..]
        .iter()
        .map(|f| {
            sinew_recording::read(
                std::path::Path::new(f),
                &sinew_recording::Options {
                    model: Some(&rig.channels[0].model),
                    columns: Some(&rig.columns),
                    ..Default::default()
                },
            )
            .unwrap()
        })
        .collect();
    let t = Instant::now();
    let last = std::sync::Mutex::new(String::new());
    let p = |s: &str, _f: f64| {
        let mut l = last.lock().unwrap();
        if *l != s {
            eprintln!("{:.1} {s}", t.elapsed().as_secs_f64());
            *l = s.into();
        }
    };
    let o =
        sinew_diagnosis::diagnose(&rig, 0, &recs, &[], &sinew_diagnosis::Settings { seed: 1, jobs: 2, progress: &p });
    match o {
        Ok(o) => {
            println!("{}", serde_json::to_string_pretty(&o.diagnosis).unwrap());
            std::fs::write("/tmp/improved.toml", o.improved.to_toml()).unwrap();
            for t in o.figures.tried.iter().take(14) {
                eprintln!(
                    "{:?} chi {:.3} dbic {:.0} chosen {} screened {}",
                    t.effects, t.holdout_chi, t.delta_bic, t.chosen, t.screened
                );
            }
            eprintln!("{}", o.diagnosis.summary);
        }
        Err(e) => println!("ERR {e}"),
    }
    eprintln!("{:.1} s", t.elapsed().as_secs_f64());
}
