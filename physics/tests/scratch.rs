//! scratch
use sinew_physics::*;
use std::fs;
fn model(name: &str) -> WireModel {
    let t: toml::Table =
        toml::from_str(&fs::read_to_string(format!("/work/shared/reference/{name}.toml")).unwrap()).unwrap();
    let c = &t["channel"][0];
    let f = |a: &str, b: &str| -> f64 {
        let v = &c[a][b];
        v.as_float().unwrap_or_else(|| v.as_integer().unwrap() as f64)
    };
    WireModel {
        geometry: Geometry { diameter_m: f("wire", "diameter_mm") * 1e-3, length_m: f("wire", "length_mm") * 1e-3 },
        material: Material::default(),
        taps: Some(Taps { l0_m: f("taps", "l0_mm") * 1e-3, ls_m: f("taps", "ls_mm") * 1e-3 }),
        drive: Drive {
            kind: DriveKind::Pwm,
            supply_v: f("drive", "supply_v"),
            shunt_ohm: f("drive", "shunt_ohm"),
            switch_ohm: f("drive", "switch_ohm"),
            lead_ohm: 0.0,
        },
        load: Load::SpringMassDamper {
            mass_kg: f("load", "mass_kg"),
            damping_n_s_per_m: f("load", "damping_n_s_per_m"),
            spring_n_per_m: f("load", "spring_n_per_m"),
            preload_n: f("load", "preload_n"),
        },
        initial: Initial::default(),
        ambient_c: 25.0,
    }
}
#[test]
fn scratch() {
    for name in ["mass-stairs", "mass-cycles", "spring-ramps", "stiff-sweep", "stiff-mixed", "heavy-thick"] {
        let m = model(name);
        let text = fs::read_to_string(format!("/work/shared/reference/{name}.csv")).unwrap();
        let rows: Vec<Vec<f64>> =
            text.lines().skip(1).map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
        for step in [1e-5, 1e-4, 1e-3, 5e-3, 1e-2] {
            let mut w = Wire::new(&m).unwrap();
            let n = (0.01f64 / step).round() as usize;
            let mut se = [0.0; 8];
            let mut lo = [1e30f64; 8];
            let mut hi = [-1e30f64; 8];
            let t0 = std::time::Instant::now();
            for r in &rows {
                let i = Inputs { drive: r[1], ..m.rest_inputs() };
                for _ in 0..n {
                    w.step(&i, step);
                }
                let o = w.outputs();
                let got = [o.current_a, o.v1_v, o.v2_v, o.v3_v, o.force_n, o.position_m, o.temperature_c, o.martensite];
                for k in 0..8 {
                    let d = got[k] - r[k + 2];
                    se[k] += d * d;
                    lo[k] = lo[k].min(r[k + 2]);
                    hi[k] = hi[k].max(r[k + 2]);
                }
            }
            let el = t0.elapsed().as_secs_f64() / (rows.len() * n) as f64 * 1e9;
            print!("{name} {step:.0e} {el:.0} ns e={:.1e}:", w.energy().residual_j() / w.energy().heat_in_j);
            for k in 0..8 {
                if k != 1 {
                    print!(" {:.4}%", 100.0 * (se[k] / rows.len() as f64).sqrt() / (hi[k] - lo[k]));
                }
            }
            println!();
        }
    }
}
