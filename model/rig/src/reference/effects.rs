//! The catalogue of effects as Markdown: the page `docs/effects.md`.

use std::fmt::Write as _;

use sinew_physics::effects::{self, Effect, EffectParameter, Equation, Home, Nature, Role};

use crate::effects::{DRAUGHT, words};
use crate::error::Plain;
use crate::parameters::parameters;
use crate::tables::Rig;

/// The catalogue as Markdown, by equation: every effect with its term and its keys.
/// `docs/effects.md` carries it word for word.
pub fn catalogue() -> String {
    let mut out = String::new();
    for equation in Equation::ALL {
        heading(&mut out, equation);
        let of_equation = |e: &&Effect| e.equation == equation && e.nature != Nature::Empirical;
        effects::catalogue().filter(of_equation).for_each(|effect| describe(&mut out, effect));
    }
    out += "## Empirical forms\n\nNo mechanisms: closed forms fitted to what none of the above explains. A fit that needs one says that \
            something is missing, in which equation, and how it goes.\n\n";
    effects::catalogue().filter(|e| e.nature == Nature::Empirical).for_each(|effect| describe(&mut out, effect));
    out
}

fn heading(out: &mut String, equation: Equation) {
    let mut name = equation.name().to_string();
    name[..1].make_ascii_uppercase();
    // writing to a String cannot fail
    let _ = write!(out, "## {name}\n\n");
}

fn describe(out: &mut String, effect: &'static Effect) {
    let table = match effect.home {
        Home::Material => "[channel.material]".to_string(),
        Home::Table => format!("[channel.effects.\"{}\"]", effect.id),
    };
    let _ = write!(out, "### `{}`\n\n{}.\n\n", effect.id, effect.says);
    let _ = write!(out, "> {}\n\n`{table}`\n\n", effect.term);
    out.push_str("| key | unit | null | default | range | rigs show | |\n|---|---|---|---|---|---|---|\n");
    for p in effect.parameters {
        let null = null(p);
        let default = match (effect.home, p.role) {
            (Home::Table, Role::Shape { .. }) if effect.id == DRAUGHT => "**required** where it acts".to_string(),
            (Home::Table, Role::Shape { default } | Role::Held { default }) => Plain(default).to_string(),
            (Home::Table, Role::Switch { .. }) => null.clone(),
            (Home::Material, _) => p.get(&Rig::hexapod().channels[0].model).to_string(),
        };
        let (least, most) = p.plausible;
        let _ = writeln!(
            out,
            "| `{}` | {} | {null} | {default} | {} to {} | {} to {} | {} |",
            p.key,
            p.unit,
            Plain(p.low),
            Plain(p.high),
            Plain(least),
            Plain(most),
            p.about.replace('|', "\\|")
        );
    }
    for word in words(effect) {
        let _ = writeln!(out, "| `{}` | | | {} | | | {} |", word.key, word.default, word.about);
    }
    out.push('\n');
}

/// The null in words: a number, or the key it has to equal; nothing for what has none.
fn null(parameter: &EffectParameter) -> String {
    let rig = Rig::hexapod();
    let model = &rig.channels[0].model;
    let Some(null) = parameter.null(model) else { return String::new() };
    let follows = |key: &str| {
        let mut other = rig.clone();
        let Some(value) = rig.parameter(0, key) else { return false };
        let moved = 1.1 * value + 1e-3;
        value == null
            && other.set_parameter(0, key, moved).is_ok()
            && parameter.null(&other.channels[0].model).is_some_and(|n| (n - moved).abs() <= 1e-9 * moved.abs())
    };
    match parameters().find(|p| follows(p.key)) {
        Some(p) => format!("= `{}`", p.key),
        None => Plain(null).to_string(),
    }
}
