//! An attempt at an explanation: the reference model refitted, the mismatch located, effects selected.

use crate::data::Data;
use crate::error::Error;
use crate::fit::Fit;
use crate::forward::{self, Selection};
use crate::locate::{self, Located};
use crate::search::{self, Agreement};
use crate::settings::Settings;
use crate::space::Space;

/// chi above which another attempt is worth its time, and the same where effects have explained most.
pub(crate) const UNEXPLAINED: f64 = 1.1;

const NEARLY_EXPLAINED: f64 = 1.3;

/// Share of what is left that effects of the catalogue have to explain to be named there.
pub(crate) const NAMED_SHARE: f64 = 0.9;

/// From the parameters alone to what physics is missing.
pub(crate) struct Attempt {
    pub(crate) agreement: Agreement,
    pub(crate) located: Vec<Located>,
    pub(crate) selection: Selection,
}

impl Attempt {
    fn new(data: &Data, space: &Space, settings: &Settings<'_>) -> Result<Attempt, Error> {
        let progress = settings.progress;
        progress("recalibrating", 0.0);
        let (reference, agreement) = search::multistart(data, space, settings.seed).ok_or(Error::NoFit)?;
        progress("locating", 0.0);
        let located = locate::locate(data, &reference, &|f| progress("locating", f));
        let windows = locate::draught_windows(data, &reference, &located);
        let mut selection = forward::select(data, reference, &windows, settings.seed, progress);
        if !selection.fit.converged {
            selection.fit = search::polish(data, selection.fit);
        }
        Ok(Attempt { agreement, located, selection })
    }
}

/// Parameters that bend freely can hide what is missing, or lead away from it. Where an attempt leaves more than noise,
/// another holds the priors as firmly as samples that share one error of the model allow; the better one is taken.
pub(crate) fn best(data: &Data, space: &Space, settings: &Settings<'_>) -> Result<Attempt, Error> {
    let free = Attempt::new(data, space, settings)?;
    let left = &free.selection.fit;
    let chi = left.score.chi();
    if chi <= UNEXPLAINED || chi <= NEARLY_EXPLAINED && free.selection.explained() >= NAMED_SHARE {
        return Ok(free);
    }
    let firmness = forward::misfit(data, left).ok_or_else(Error::lost_fit)?;
    let firm = Attempt::new(data, &space.firm(firmness), settings)?;
    let misfit = forward::misfit(data, &firm.selection.fit).ok_or_else(Error::lost_fit)?.min(firmness);
    let worth = |fit: &Fit| fit.score.sum() / misfit + fit.space.penalty(&fit.z);
    Ok(if worth(&firm.selection.fit) < worth(&free.selection.fit) { firm } else { free })
}
