//! The answer: what `diagnosis.json` says, and beside it what the report draws.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sinew_recording::Column;

/// The name of the format of [`Diagnosis`].
pub const SCHEMA: &str = "sinew.diagnosis/1";

/// What a diagnosis came to; serialises to `diagnosis.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// [`SCHEMA`].
    pub schema: String,
    /// The answer in a word.
    pub verdict: Verdict,
    /// The answer in two or three sentences, for a person.
    pub summary: String,
    /// Noise of every sensor judged by, RMS, by column.
    pub noise: BTreeMap<String, f64>,
    /// How well the model fits the data kept back, by stage.
    pub fit: Stages,
    /// Whether anything is left after recalibration, and how sure that is.
    pub left: Left,
    /// Where it is.
    #[serde(rename = "where")]
    pub location: Location,
    /// The effects that are needed: those borne out first, the larger share first.
    pub effects: Vec<FoundEffect>,
    /// Transformation curves of another shape than the rig file's, where they are needed: no mechanism, but what remains of a
    /// wire that follows no closed form.
    #[serde(default)]
    pub curves: Option<FoundEffect>,
    /// Share of what was wrong with the rig file as given that its parameters account for, tolerances included; the effects
    /// have the rest.
    pub parameters_share: f64,
    /// What is outside the catalogue.
    pub unknown: Option<Unknown>,
    /// What is left with everything that was found in the model.
    pub remains: Remains,
    /// Every model that was tried, best first: the evidence table.
    #[serde(default)]
    pub tried: Vec<Tried>,
    /// Constants stated as known that are off by more than their tolerance, and sensors likewise.
    pub beyond_tolerance: Vec<BeyondTolerance>,
    /// Parameters of the reference model that a fit may move, by key.
    pub parameters: BTreeMap<String, FittedParameter>,
    /// What is nuisance per recording: an arbitrary zero, run-to-run scatter. By recording, then name.
    pub recordings: Vec<RecordingSummary>,
    /// What recording would tell more.
    pub next_experiment: String,
    /// Warnings a reader must know of: a parameter outside its range, a fit that did not converge, a doubtful sensor.
    pub warnings: Vec<String>,
    /// Which blocks were kept back: the same seed, the same blocks.
    pub seed: u64,
}

impl Diagnosis {
    /// Whether what was found accounts for the recording: what remains is noise, or less than that of curves that are described.
    pub fn is_explained(&self) -> bool {
        self.remains.is_explained(self.curves.as_ref())
    }
}

/// The answer in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The rig file as given explains the recording.
    Agrees,
    /// The same physics with other parameters does.
    ParametersOff,
    /// One or more effects of the catalogue are needed.
    PhysicsMissing,
    /// Something is, and no effect of the catalogue is it.
    UnknownPhysics,
}

impl Verdict {
    /// Its word in the JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::ParametersOff => "parameters_off",
            Verdict::PhysicsMissing => "physics_missing",
            Verdict::UnknownPhysics => "unknown_physics",
        }
    }

    /// Whether the model's physics is as it was: nothing was named that is missing from it.
    pub const fn is_complete(self) -> bool {
        matches!(self, Verdict::Agrees | Verdict::ParametersOff)
    }
}

/// Error by sensor column, at three stages, on data kept back.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Stages {
    /// With the rig file as it is.
    pub as_given: BTreeMap<String, Misfit>,
    /// With parameters refitted within their priors.
    pub recalibrated: BTreeMap<String, Misfit>,
    /// With what was found in the model.
    pub improved: BTreeMap<String, Misfit>,
}

/// RMS error of one sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Misfit {
    /// In the column's unit.
    pub rmse: f64,
    /// Over the sensor's noise; 1 = nothing left to explain.
    pub chi: f64,
}

/// Whether anything is left after recalibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Left {
    /// chi over all sensors on data kept back, as given.
    pub chi_as_given: f64,
    /// chi over all sensors on data kept back, recalibrated.
    pub chi: f64,
    /// chi over all sensors on data kept back, improved.
    pub chi_improved: f64,
    /// Upper bound of the probability that the best candidate looks this good where nothing is missing.
    pub p_value: f64,
    /// How the p-value was made, in a sentence.
    pub method: String,
}

/// Where the mismatch is.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Location {
    /// The guilty equation; none where nothing is left.
    pub equation: Option<String>,
    /// Share of what is left where it is fitted that an unknown input to each equation explains: such an input says
    /// nothing of times it was not fitted to.
    pub equation_scores: BTreeMap<String, f64>,
    /// When.
    pub windows: Vec<Window>,
    /// Under which conditions.
    pub conditions: Vec<Condition>,
}

/// A window in time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Window {
    /// Name of the recording.
    pub recording: String,
    /// From, s.
    pub start_s: f64,
    /// To, s.
    pub end_s: f64,
    /// Share of what is left that lies inside.
    pub share: f64,
}

/// A condition of the wire.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// In words.
    pub when: String,
    /// Share of what is left that lies inside.
    pub share: f64,
    /// Share of the samples that lies inside: what `share` would be if the mismatch were everywhere alike.
    pub of_time: f64,
}

/// An effect of the catalogue that is needed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundEffect {
    /// Its id.
    pub id: String,
    /// What it does here, with numbers.
    pub says: String,
    /// Its parameters.
    pub parameters: BTreeMap<String, EffectSize>,
    /// Share of what was wrong with the rig file as given that it accounts for; the parameters and the other effects have
    /// the rest.
    pub share: f64,
    /// How well it is borne out.
    pub grade: Grade,
    /// Why it is believed.
    pub evidence: Evidence,
    /// What else was tried in its place, best first.
    pub alternatives: Vec<Alternative>,
    /// Effects that explain the recording equally well.
    pub cannot_be_told_apart_from: Vec<String>,
}

/// How well an effect is borne out by what no fit has seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Grade {
    /// A whole recording kept back is more probable with it.
    ConfirmedOnAnotherProgramme,
    /// Blocks kept back of the same recordings are.
    OnThisProgrammeOnly,
    /// The fit is better with it, what is kept back is not, or the evidence is weak.
    Suspected,
}

impl Grade {
    /// In words.
    pub const fn says(self) -> &'static str {
        match self {
            Grade::ConfirmedOnAnotherProgramme => "confirmed on another programme",
            Grade::OnThisProgrammeOnly => "on this programme only",
            Grade::Suspected => "suspected",
        }
    }
}

/// What is left with everything that was found in the model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Remains {
    /// chi over all sensors on data kept back.
    pub chi: f64,
    /// What it looks like.
    pub looks_like: LooksLike,
    /// By sensor column.
    pub sensors: BTreeMap<String, SensorRemains>,
    /// Share of it that an unknown input to each equation explains.
    pub equations: BTreeMap<String, f64>,
    /// When.
    pub windows: Vec<Window>,
    /// Under which conditions.
    pub conditions: Vec<Condition>,
}

impl Remains {
    /// Whether nothing is left but noise, and less than that in every sensor of `curves` that were found.
    pub(crate) fn is_explained(&self, curves: Option<&FoundEffect>) -> bool {
        match self.looks_like {
            LooksLike::Noise => true,
            LooksLike::Curves => curves.is_some() && self.sensors.values().all(|left| left.over_noise < 1.0),
            LooksLike::MissingMechanism => false,
        }
    }
}

/// What is left in one sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SensorRemains {
    /// Error of the model beside the sensor's noise, RMS, in the column's unit.
    pub rms: f64,
    /// Over the sensor's noise.
    pub over_noise: f64,
    /// For how long it keeps its sign, s.
    pub memory_s: f64,
}

/// What a remainder looks like.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LooksLike {
    /// Noise of the sensors, in every sensor by itself.
    #[default]
    Noise,
    /// Transformation curves of another shape than the model's.
    Curves,
    /// A mechanism that is not in the model.
    MissingMechanism,
}

impl LooksLike {
    /// In words.
    pub const fn says(self) -> &'static str {
        match self {
            LooksLike::Noise => "noise of the sensors",
            LooksLike::Curves => "transformation curves of another shape",
            LooksLike::MissingMechanism => "a mechanism that is not in the model",
        }
    }
}

/// A constant stated as known, or a sensor, that is off by more than its tolerance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BeyondTolerance {
    /// Key of the rig file.
    pub key: String,
    /// By how many σ of its tolerance.
    pub sigmas: f64,
    /// In a sentence.
    pub says: String,
}

/// A fitted parameter of an effect with its 90 % interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EffectSize {
    /// In `unit`.
    pub value: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
    /// Unit of the rig file's key.
    pub unit: String,
}

/// Why an effect is believed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// chi on data kept back with all found effects but this one, everything else refitted.
    pub holdout_chi_before: f64,
    /// chi on data kept back with all found effects.
    pub holdout_chi_after: f64,
    /// Minus twice the rise of the log evidence when it is added: what a Bayesian information criterion approximates.
    pub delta_bic: f64,
    /// Upper bound of the probability of evidence this strong if it were not there.
    pub p_value: f64,
    /// Rise of the log probability of what was kept back when it is added.
    #[serde(default)]
    pub holdout_rise: f64,
}

/// Another effect in the place of one found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alternative {
    /// Its id.
    pub id: String,
    /// Minus twice the log evidence with it in the found one's place, less that of the found one: positive = worse.
    pub delta_bic: f64,
    /// chi on data kept back with it.
    pub holdout_chi: f64,
}

/// A closed form for what no effect of the catalogue explains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Unknown {
    /// The equation it is a term of.
    pub equation: String,
    /// The form, with numbers and units; empty where none was found.
    pub form: String,
    /// Unit of the form.
    pub unit: String,
    /// Its coefficients in the rig file's `[channel.effects."empirical.…"]`.
    pub coefficients: BTreeMap<String, EffectSize>,
    /// chi on data kept back without it.
    pub holdout_chi_before: f64,
    /// chi on data kept back with it.
    pub holdout_chi_after: f64,
}

/// A parameter before and after.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FittedParameter {
    /// In the rig file.
    pub given: f64,
    /// Fitted.
    pub value: f64,
    /// Lower end of the 90 % interval.
    pub low: f64,
    /// Upper end of the 90 % interval.
    pub high: f64,
    /// Unit of the key.
    pub unit: String,
    /// 1 σ of the prior, in the unit.
    pub prior_sigma: f64,
}

/// What was fitted of one recording alone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordingSummary {
    /// Its name.
    pub name: String,
    /// Samples.
    pub samples: usize,
    /// Length, s.
    pub duration_s: f64,
    /// Whether all of it was kept back.
    pub held_out: bool,
    /// chi over all sensors on its kept-back part, improved; none where nothing of it is kept back.
    pub chi: Option<f64>,
    /// Offsets fitted for this recording alone, by column, in its unit.
    pub offsets: BTreeMap<String, f64>,
}

/// What the report draws; not part of the JSON.
#[derive(Debug, Clone)]
pub struct Figures {
    /// One per recording.
    pub recordings: Vec<Traces>,
    /// Residual by condition: rows × columns of [`Map`], recalibrated and improved.
    pub maps: Vec<Map>,
    /// The unknown input of each equation over time in the first recording, in `unit`.
    pub unknown_inputs: Vec<UnknownInput>,
}

/// One recording as measured and simulated, thinned for drawing (at most about 3000 points).
#[derive(Debug, Clone)]
pub struct Traces {
    /// Name of the recording.
    pub name: String,
    /// Times, s.
    pub time_s: Vec<f64>,
    /// The drive's input, in its column's unit.
    pub drive: Vec<f64>,
    /// Which column the drive is.
    pub drive_column: Column,
    /// Intervals kept back, s.
    pub kept_back: Vec<(f64, f64)>,
    /// Wire temperature in the improved model, °C.
    pub temperature_c: Vec<f64>,
    /// Martensite fraction in the improved model.
    pub martensite: Vec<f64>,
    /// One per sensor that was judged.
    pub sensors: Vec<SensorTrace>,
}

/// One sensor.
#[derive(Debug, Clone)]
pub struct SensorTrace {
    /// Its column.
    pub column: Column,
    /// Noise, RMS, in the column's unit.
    pub noise: f64,
    /// Measured; NaN = missing.
    pub measured: Vec<f64>,
    /// With the rig file as given.
    pub as_given: Vec<f64>,
    /// Recalibrated.
    pub recalibrated: Vec<f64>,
    /// Improved.
    pub improved: Vec<f64>,
}

/// RMS residual over noise in bins of two conditions, all sensors together.
#[derive(Debug, Clone)]
pub struct Map {
    /// What is on the horizontal axis, with unit.
    pub x: String,
    /// Edges of its bins.
    pub x_edges: Vec<f64>,
    /// What is on the vertical axis, with unit.
    pub y: String,
    /// Edges of its bins.
    pub y_edges: Vec<f64>,
    /// Recalibrated chi, `[y][x]`; NaN where there are no samples.
    pub before: Vec<Vec<f64>>,
    /// Improved chi.
    pub after: Vec<Vec<f64>>,
}

/// What an equation would have to be given to explain the recording.
#[derive(Debug, Clone)]
pub struct UnknownInput {
    /// The equation.
    pub equation: String,
    /// What the input is, such as "heat into the wire".
    pub what: String,
    /// Its unit.
    pub unit: String,
    /// Share of what is left, where it is fitted, that it explains.
    pub score: f64,
    /// Times of its knots, s.
    pub time_s: Vec<f64>,
    /// Its values.
    pub value: Vec<f64>,
}

/// One model that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tried {
    /// Effects in it beyond the recalibrated model.
    pub effects: Vec<String>,
    /// chi on data kept back.
    pub holdout_chi: f64,
    /// BIC less that of the recalibrated model.
    pub delta_bic: f64,
    /// Chosen.
    pub chosen: bool,
    /// Only screened, not refitted in full.
    pub screened: bool,
}
