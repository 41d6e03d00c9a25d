//! Chapter 3: the model of the alloy.

mod constitutive;
mod continuity;
mod criteria;
mod kinetics;
mod shared;

use crate::row::Row;

pub(crate) fn rows() -> Vec<Row> {
    let mut rows = constitutive::constitutive();
    rows.extend(criteria::criteria());
    rows.extend(kinetics::kinetics());
    rows.extend(continuity::summary());
    rows.extend(continuity::continuity());
    rows
}
