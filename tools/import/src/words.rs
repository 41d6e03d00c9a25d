//! What a column's name says that it is, in English, German, French and Japanese.

use sinew_recording::Column;

use crate::units::Dimension;

/// What a column may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Role {
    Time,
    /// The number of the sample.
    Sample,
    /// A column of a recording.
    Is(Column),
    /// The wire's whole length, where a recording has its elongation.
    Length,
    Strain,
    Stress,
    /// A voltage, of the supply or of the wire.
    Voltage,
    /// A temperature, of the wire or of the air.
    Temperature,
    Resistance,
    /// What was asked for, not what was measured.
    Wanted,
    /// Something a recording has no column for.
    Other,
}

impl Role {
    pub(crate) fn dimension(self) -> Option<Dimension> {
        Some(match self {
            Role::Time => Dimension::Time,
            Role::Is(Column::Duty) | Role::Strain => Dimension::Ratio,
            Role::Is(Column::PowerW) => Dimension::Power,
            Role::Is(Column::TemperatureC | Column::AmbientC) | Role::Temperature => Dimension::Temperature,
            Role::Is(Column::SupplyV | Column::V1V | Column::V2V | Column::V3V) | Role::Voltage => Dimension::Voltage,
            Role::Is(Column::CurrentA) => Dimension::Current,
            Role::Is(Column::ForceN | Column::DisturbanceN) => Dimension::Force,
            Role::Is(Column::PositionM) | Role::Length => Dimension::Length,
            Role::Stress => Dimension::Stress,
            Role::Resistance => Dimension::Resistance,
            Role::Sample | Role::Wanted | Role::Other => return None,
        })
    }
}

/// What a name says.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Said {
    pub role: Role,
    /// The word it was known by.
    pub word: &'static str,
    /// The name says that it counts shortening.
    pub shortening: bool,
    /// Computed from another column: filtered, smoothed, a deviation.
    pub derived: bool,
}

use Role::{Is, Length, Other, Resistance, Sample, Strain, Stress, Temperature, Time, Voltage, Wanted};

/// Words that are looked for anywhere in a name (compounds: "Drahttemperatur"), longer and rarer ones first.
const WITHIN: &[(&str, Role)] = &[
    // what only resembles a quantity
    ("heartbeat", Other),
    ("geschwindigkeit", Other),
    ("velocity", Other),
    ("vitesse", Other),
    ("速度", Other),
    ("frequenz", Other),
    ("frequency", Other),
    ("energie", Other),
    ("energy", Other),
    ("humid", Other),
    ("feucht", Other),
    ("pressure", Other),
    ("druck", Other),
    ("fehler", Other),
    ("error", Other),
    ("status", Other),
    ("trigger", Other),
    ("zyklus", Other),
    ("cycle", Other),
    ("サイクル", Other),
    ("comment", Other),
    ("kommentar", Other),
    ("martensit", Other),
    // time
    ("x_value", Time),
    ("timestamp", Time),
    ("zeitstempel", Time),
    ("horodat", Time),
    ("uhrzeit", Time),
    ("zeit", Time),
    ("temps", Time),
    ("time", Time),
    ("elapsed", Time),
    ("millis", Time),
    ("micros", Time),
    ("時間", Time),
    ("時刻", Time),
    ("経過", Time),
    ("heure", Time),
    ("messpunkt", Sample),
    ("sample", Sample),
    ("index", Sample),
    ("échantillon", Sample),
    ("echantillon", Sample),
    ("サンプル", Sample),
    ("番号", Sample),
    // wire voltages before voltages
    ("abgriff", Voltage),
    ("versorgung", Is(Column::SupplyV)),
    ("netzteil", Is(Column::SupplyV)),
    ("alimentation", Is(Column::SupplyV)),
    ("電源", Is(Column::SupplyV)),
    ("supply", Is(Column::SupplyV)),
    ("batterie", Is(Column::SupplyV)),
    ("battery", Is(Column::SupplyV)),
    // duty
    ("tastgrad", Is(Column::Duty)),
    ("tastverh", Is(Column::Duty)),
    ("duty", Is(Column::Duty)),
    ("pwm", Is(Column::Duty)),
    ("rapport cyclique", Is(Column::Duty)),
    ("rapportcyclique", Is(Column::Duty)),
    ("デューティ", Is(Column::Duty)),
    ("stellgr", Is(Column::Duty)),
    ("aussteuerung", Is(Column::Duty)),
    // temperatures of the air before temperatures
    ("umgebung", Is(Column::AmbientC)),
    ("raumtemp", Is(Column::AmbientC)),
    ("zimmertemp", Is(Column::AmbientC)),
    ("lufttemp", Is(Column::AmbientC)),
    ("ambient", Is(Column::AmbientC)),
    ("ambiante", Is(Column::AmbientC)),
    ("room temp", Is(Column::AmbientC)),
    ("air temp", Is(Column::AmbientC)),
    ("室温", Is(Column::AmbientC)),
    ("周囲", Is(Column::AmbientC)),
    ("雰囲気", Is(Column::AmbientC)),
    ("環境", Is(Column::AmbientC)),
    ("tamb", Is(Column::AmbientC)),
    ("troom", Is(Column::AmbientC)),
    ("drahttemp", Is(Column::TemperatureC)),
    ("wire temp", Is(Column::TemperatureC)),
    ("probentemp", Is(Column::TemperatureC)),
    ("temperatur", Temperature),
    ("température", Temperature),
    ("temperature", Temperature),
    ("温度", Temperature),
    ("thermocouple", Temperature),
    ("thermoelement", Temperature),
    ("熱電対", Temperature),
    // resistance before anything with "wider"
    ("widerstand", Resistance),
    ("resistance", Resistance),
    ("résistance", Resistance),
    ("抵抗", Resistance),
    ("resistivity", Other),
    // strain and stress before lengths and voltages
    ("spannung_mpa", Stress),
    ("zugspannung", Stress),
    ("stress", Stress),
    ("contrainte", Stress),
    ("応力", Stress),
    ("dehnung", Strain),
    ("strain", Strain),
    ("déformation", Strain),
    ("ひずみ", Strain),
    ("歪", Strain),
    ("spannung", Voltage),
    ("voltage", Voltage),
    ("tension électrique", Voltage),
    ("tension elec", Voltage),
    ("電圧", Voltage),
    ("strom", Is(Column::CurrentA)),
    ("current", Is(Column::CurrentA)),
    ("courant", Is(Column::CurrentA)),
    ("intensité", Is(Column::CurrentA)),
    ("電流", Is(Column::CurrentA)),
    ("heizleistung", Is(Column::PowerW)),
    ("leistung", Is(Column::PowerW)),
    ("power", Is(Column::PowerW)),
    ("puissance", Is(Column::PowerW)),
    ("電力", Is(Column::PowerW)),
    ("störkraft", Is(Column::DisturbanceN)),
    ("disturbance", Is(Column::DisturbanceN)),
    ("kraft", Is(Column::ForceN)),
    ("force", Is(Column::ForceN)),
    ("last", Is(Column::ForceN)),
    ("load", Is(Column::ForceN)),
    ("effort", Is(Column::ForceN)),
    ("荷重", Is(Column::ForceN)),
    ("張力", Is(Column::ForceN)),
    ("verkürzung", Is(Column::PositionM)),
    ("verkuerzung", Is(Column::PositionM)),
    ("kontraktion", Is(Column::PositionM)),
    ("contraction", Is(Column::PositionM)),
    ("shortening", Is(Column::PositionM)),
    ("raccourcissement", Is(Column::PositionM)),
    ("収縮", Is(Column::PositionM)),
    ("verlängerung", Is(Column::PositionM)),
    ("auslenkung", Is(Column::PositionM)),
    ("verschiebung", Is(Column::PositionM)),
    ("displacement", Is(Column::PositionM)),
    ("déplacement", Is(Column::PositionM)),
    ("deplacement", Is(Column::PositionM)),
    ("allongement", Is(Column::PositionM)),
    ("elongation", Is(Column::PositionM)),
    ("extension", Is(Column::PositionM)),
    ("position", Is(Column::PositionM)),
    ("stroke", Is(Column::PositionM)),
    ("course", Is(Column::PositionM)),
    ("wegaufnehmer", Is(Column::PositionM)),
    ("wegsensor", Is(Column::PositionM)),
    ("lvdt", Is(Column::PositionM)),
    ("encoder", Is(Column::PositionM)),
    ("変位", Is(Column::PositionM)),
    ("位置", Is(Column::PositionM)),
    ("伸び", Is(Column::PositionM)),
    ("ストローク", Is(Column::PositionM)),
    ("traverse", Is(Column::PositionM)),
    ("crosshead", Is(Column::PositionM)),
    ("drahtlänge", Length),
    ("länge", Length),
    ("laenge", Length),
    ("length", Length),
    ("longueur", Length),
    ("長さ", Length),
    ("全長", Length),
];

/// Words that are a name, or a part of one, by themselves.
const WORDS: &[(&str, Role)] = &[
    ("t", Time),
    ("sec", Time),
    ("ts", Time),
    ("datum", Time),
    ("date", Time),
    ("clock", Time),
    ("日時", Time),
    ("nr", Sample),
    ("no", Sample),
    ("n", Sample),
    ("num", Sample),
    ("idx", Sample),
    ("i#", Sample),
    ("lfd", Sample),
    ("u", Voltage),
    ("v", Voltage),
    ("volt", Voltage),
    ("volts", Voltage),
    ("tension", Voltage),
    ("ubat", Is(Column::SupplyV)),
    ("vcc", Is(Column::SupplyV)),
    ("vdd", Is(Column::SupplyV)),
    ("vbat", Is(Column::SupplyV)),
    ("vin", Is(Column::SupplyV)),
    ("usupply", Is(Column::SupplyV)),
    ("vs", Is(Column::SupplyV)),
    ("u1", Is(Column::V1V)),
    ("v1", Is(Column::V1V)),
    ("u2", Is(Column::V2V)),
    ("v2", Is(Column::V2V)),
    ("u3", Is(Column::V3V)),
    ("v3", Is(Column::V3V)),
    ("udraht", Is(Column::V3V)),
    ("vwire", Is(Column::V3V)),
    ("uwire", Is(Column::V3V)),
    ("i", Is(Column::CurrentA)),
    ("amp", Is(Column::CurrentA)),
    ("amps", Is(Column::CurrentA)),
    ("ampere", Is(Column::CurrentA)),
    ("iheiz", Is(Column::CurrentA)),
    ("iwire", Is(Column::CurrentA)),
    ("p", Is(Column::PowerW)),
    ("watt", Is(Column::PowerW)),
    ("pel", Is(Column::PowerW)),
    ("pheiz", Is(Column::PowerW)),
    ("heat", Is(Column::PowerW)),
    ("dc", Is(Column::Duty)),
    ("d", Is(Column::Duty)),
    ("tv", Is(Column::Duty)),
    ("rc", Is(Column::Duty)),
    ("f", Is(Column::ForceN)),
    ("fz", Is(Column::ForceN)),
    ("kg", Is(Column::ForceN)),
    ("x", Is(Column::PositionM)),
    ("s", Is(Column::PositionM)),
    ("z", Is(Column::PositionM)),
    ("pos", Is(Column::PositionM)),
    ("weg", Is(Column::PositionM)),
    ("hub", Is(Column::PositionM)),
    ("disp", Is(Column::PositionM)),
    ("ext", Is(Column::PositionM)),
    ("elong", Is(Column::PositionM)),
    ("dl", Is(Column::PositionM)),
    ("l", Length),
    ("len", Length),
    ("temp", Temperature),
    ("tc", Temperature),
    ("tc1", Temperature),
    ("temp1", Temperature),
    ("t1", Temperature),
    ("tdraht", Is(Column::TemperatureC)),
    ("twire", Is(Column::TemperatureC)),
    ("tw", Is(Column::TemperatureC)),
    ("tu", Is(Column::AmbientC)),
    ("ta", Is(Column::AmbientC)),
    ("r", Resistance),
    ("ohm", Resistance),
    ("res", Resistance),
    ("sigma", Stress),
    ("σ", Stress),
    ("eps", Strain),
    ("epsilon", Strain),
    ("ε", Strain),
];

/// What was asked for.
const WANTED: &[&str] =
    &["soll", "setpoint", "set point", "target", "consigne", "目標", "指令", "cmd", "command", "reference", "vorgabe"];
const WANTED_WORDS: &[&str] = &["set", "sp", "ref"];
/// What is computed.
const DERIVED: &[&str] = &[
    "filter",
    "gefilt",
    "glatt",
    "geglätt",
    "smooth",
    "lissé",
    "filtré",
    "平均",
    "mean",
    "mittel",
    "average",
    "stddev",
    "std dev",
    "standardabw",
    "gain",
    "raw adc",
];
/// What counts the wire's shortening.
const SHORTENING: &[&str] = &["verkürz", "verkuerz", "kontraktion", "contraction", "shorten", "raccourc", "収縮"];
/// What is of the wire.
const OF_THE_WIRE: &[&str] =
    &["draht", "wire", "fil ", "fil_", "ワイヤ", "sma", "probe", "sample", "specimen", "試験片", "échantillon"];

/// The words of a name: at blanks, signs and where capitals begin.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for c in name.chars() {
        if !c.is_alphanumeric() || (before.is_lowercase() && c.is_uppercase()) {
            words.push(String::new());
        }
        if c.is_alphanumeric() {
            words.last_mut().into_iter().for_each(|word| word.extend(c.to_lowercase()));
        }
        before = c;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// What a name without its unit says; the unit's dimension decides where words do not.
pub(crate) fn said(name: &str, dimension: Option<Dimension>) -> Option<Said> {
    let lower = name.to_lowercase();
    let words = words(name);
    let fits = |role: Role| dimension.is_none_or(|d| role.dimension().is_none_or(|own| own == d));
    let derived = DERIVED.iter().any(|word| lower.contains(word));
    let shortening = SHORTENING.iter().any(|word| lower.contains(word));
    let found = |role, word| Some(Said { role, word, shortening, derived });
    // a role of its own name: sinew's columns
    if let Some(column) = Column::from_name(&lower).or_else(|| {
        Column::ALL.into_iter().find(|c| fits(Is(*c)) && c.name().rsplit_once('_').is_some_and(|(n, _)| n == lower))
    }) {
        return found(Is(column), column.name());
    }
    let tap = |lower: &str| {
        let taps = [
            ("tap 1", Column::V1V),
            ("tap1", Column::V1V),
            ("tap_1", Column::V1V),
            ("tap 2", Column::V2V),
            ("tap2", Column::V2V),
            ("tap_2", Column::V2V),
            ("abgriff 1", Column::V1V),
            ("abgriff1", Column::V1V),
            ("abgriff 2", Column::V2V),
            ("abgriff2", Column::V2V),
        ];
        taps.into_iter().find(|(word, _)| lower.contains(word))
    };
    if let Some((word, column)) = tap(&lower).filter(|_| dimension.is_none_or(|d| d == Dimension::Voltage)) {
        return found(Is(column), word);
    }
    let wanted =
        WANTED.iter().any(|word| lower.contains(word)) || words.iter().any(|w| WANTED_WORDS.contains(&w.as_str()));
    let within =
        WITHIN.iter().find(|(word, role)| lower.contains(word) && fits(*role) && !inside_another(word, &lower));
    let alone = || WORDS.iter().find(|(word, role)| words.iter().any(|w| w == word) && fits(*role));
    let (word, role) = match within.or_else(alone) {
        Some((word, role)) => (*word, *role),
        // no word, but a unit that only one quantity has
        None => match dimension? {
            Dimension::Time => ("its unit", Time),
            Dimension::Current => ("its unit", Is(Column::CurrentA)),
            Dimension::Power => ("its unit", Is(Column::PowerW)),
            Dimension::Resistance => ("its unit", Resistance),
            Dimension::Stress => ("its unit", Stress),
            Dimension::Force => ("its unit", Is(Column::ForceN)),
            Dimension::Length => ("its unit", Is(Column::PositionM)),
            Dimension::Voltage => ("its unit", Voltage),
            Dimension::Temperature => ("its unit", Temperature),
            Dimension::Ratio | Dimension::Other => {
                return found(Other, "its unit").filter(|_| dimension == Some(Dimension::Other));
            }
        },
    };
    // a duty is asked for by its nature
    let role = match role {
        _ if wanted && !matches!(role, Is(Column::Duty) | Time | Sample) => Wanted,
        // T_wire is no time
        Time if word == "t"
            && dimension.is_none()
            && OF_THE_WIRE.iter().any(|of| *of != "sample" && lower.contains(of)) =>
        {
            Is(Column::TemperatureC)
        }
        Voltage if OF_THE_WIRE.iter().any(|of| lower.contains(of)) => Is(Column::V3V),
        Temperature if OF_THE_WIRE.iter().any(|of| lower.contains(of)) => Is(Column::TemperatureC),
        role => role,
    };
    found(role, word)
}

/// Short words that other words have within: "last" in "elastic", "load" in "payload" are none.
fn inside_another(word: &str, name: &str) -> bool {
    match word {
        "last" => {
            !words(name).iter().any(|w| w == "last" || w.starts_with("last") && w != "lastly" || w.ends_with("last"))
                || name.contains("elast")
        }
        "time" => name.contains("timeout") || name.contains("sentiment"),
        "strom" => name.contains("stromlos"),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_four_languages_are_known() {
        use Dimension as D;
        for (name, dimension, role) in [
            ("Zeit", Some(D::Time), Time),
            ("経過時間", None, Time),
            ("Temps", Some(D::Time), Time),
            ("Heizstrom", Some(D::Current), Is(Column::CurrentA)),
            ("電流", None, Is(Column::CurrentA)),
            ("Umgebungstemperatur", None, Is(Column::AmbientC)),
            ("Drahttemperatur", None, Is(Column::TemperatureC)),
            ("Température ambiante", None, Is(Column::AmbientC)),
            ("Temp", None, Temperature),
            ("Spannung", Some(D::Stress), Stress),
            ("Spannung", Some(D::Voltage), Voltage),
            ("Spannung Draht", Some(D::Voltage), Is(Column::V3V)),
            ("Versorgungsspannung", None, Is(Column::SupplyV)),
            ("Tastverhältnis", Some(D::Ratio), Is(Column::Duty)),
            ("Weg", Some(D::Length), Is(Column::PositionM)),
            ("Sollweg", Some(D::Length), Wanted),
            ("変位", None, Is(Column::PositionM)),
            ("荷重", Some(D::Force), Is(Column::ForceN)),
            ("Load", Some(D::Force), Is(Column::ForceN)),
            ("tension", Some(D::Voltage), Voltage),
            ("x", Some(D::Length), Is(Column::PositionM)),
            ("Kanal 3", Some(D::Force), Is(Column::ForceN)),
            ("V1", None, Is(Column::V1V)),
            ("T_wire", None, Is(Column::TemperatureC)),
            ("position", Some(D::Length), Is(Column::PositionM)),
        ] {
            assert_eq!(said(name, dimension).map(|s| s.role), Some(role), "{name}");
        }
        assert!(said("Verkürzung", None).unwrap().shortening);
        assert!(said("Kraft gefiltert", None).unwrap().derived);
        assert_eq!(said("elastic modulus", None), None);
        assert_eq!(said("bananas", None), None);
    }
}
