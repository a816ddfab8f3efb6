//! Places whose way is told, checked.

use nalgebra::Vector3;

use super::super::raw::RawSpaceScene;
use super::Organ;
use super::numbers::triple;
use crate::numbers::{Checked, named};

/// A target as the scene names it.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// For people.
    pub name: String,
    /// At rest, in the patient: LPS, mm.
    pub at: Vector3<f64>,
    /// Number of the organ that it must lie in; `None`: whichever it lies in.
    pub organ: Option<usize>,
}

pub(super) fn targets(raw: &RawSpaceScene, organs: &[Organ]) -> Checked<Vec<Wanted>> {
    let each = raw.targets.iter().enumerate().map(|(k, target)| {
        let organ = target.organ.as_ref().map(|name| {
            let key = format!("targets.{k}.organ");
            named(&key, name, organs.iter().map(|o| o.name.as_str()))
        });
        Ok(Wanted {
            name: target.name.clone(),
            at: triple(&format!("targets.{k}.at"), target.at)?,
            organ: organ.transpose()?,
        })
    });
    each.collect()
}
