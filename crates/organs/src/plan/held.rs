//! What does not move, and how organs are attached to it, checked.

use super::super::raw::{RawAttachment, RawContact, RawKind, RawSpaceScene};
use super::numbers::length;
use super::spread::young;
use super::{Attachment, Contact, MOST_RIGID, Organ, Rigid};
use crate::numbers::{Checked, invalid, named, within};

/// The most labels of one table.
const MOST_LABELS: usize = 256;

/// Labels that do not move; each label is of one table only.
pub(super) fn rigid(raw: &RawSpaceScene, organs: &[Organ]) -> Checked<Vec<Rigid>> {
    let mut seen = std::collections::BTreeMap::new();
    for (k, organ) in organs.iter().enumerate() {
        if let Some(other) = seen.insert(organ.label, organ.name.as_str()) {
            return Err(invalid(
                format!("organs.{k}.label"),
                format!("{}, which is {other:?} already", organ.label),
                "a label of its own",
            ));
        }
    }
    for (k, rigid) in raw.rigid.iter().enumerate() {
        within(&format!("rigid.{k}.labels"), rigid.labels.len(), 1..=MOST_LABELS)?;
        for (i, label) in rigid.labels.iter().enumerate() {
            let key = format!("rigid.{k}.labels.{i}");
            if *label == 0 {
                return Err(invalid(key, 0, "a label of the map, above 0"));
            }
            if let Some(other) = seen.insert(*label, rigid.name.as_str()) {
                return Err(invalid(
                    key,
                    format!("{label}, which is {other:?} already"),
                    "a label of its own",
                ));
            }
        }
    }
    Ok(raw
        .rigid
        .iter()
        .map(|r| Rigid {
            name: r.name.clone(),
            labels: r.labels.clone(),
        })
        .collect())
}

/// Numbers of what is rigid, by names.
fn rigids(key: &str, names: &[String], rigid: &[Rigid]) -> Checked<Vec<usize>> {
    within(key, names.len(), 1..=MOST_RIGID)?;
    let each = names.iter().enumerate();
    each.map(|(i, name)| named(&format!("{key}.{i}"), name, rigid.iter().map(|r| r.name.as_str())))
        .collect()
}

pub(super) fn contact(k: usize, raw: &RawContact, organs: &[Organ], rigid: &[Rigid]) -> Checked<Contact> {
    let key = |last: &str| format!("contacts.{k}.{last}");
    let organ = named(&key("organ"), &raw.organ, organs.iter().map(|o| o.name.as_str()))?;
    let smoothing = raw.smoothing.unwrap_or(organs[organ].smoothing.sigma);
    let good = (0.0..=100.0).contains(&smoothing);
    Ok(Contact {
        organ,
        with: rigids(&key("with"), &raw.with, rigid)?,
        smoothing: good
            .then_some(smoothing)
            .ok_or_else(|| invalid(key("smoothing"), smoothing, "0 to 100 mm"))?,
        ball: length(&key("ball"), raw.ball)?,
    })
}

pub(super) fn attachment(k: usize, raw: &RawAttachment, organs: &[Organ], rigid: &[Rigid]) -> Checked<Attachment> {
    let key = |last: &str| format!("attachments.{k}.{last}");
    let organ = named(&key("organ"), &raw.organ, organs.iter().map(|o| o.name.as_str()))?;
    let to = rigids(&key("to"), &raw.to, rigid)?;
    let tied = match (raw.kind, raw.young, raw.margin) {
        (RawKind::Tied, Some(modulus), Some(margin)) => {
            let young = young(&format!("attachments.{k}"), modulus, raw.young_spread)?;
            Some((young, young.value / length(&key("margin"), margin)?))
        }
        (RawKind::Fixed, None, None) if raw.young_spread.is_some() => {
            return Err(invalid(
                key("young_spread"),
                "a number",
                "nothing with kind = \"fixed\", which has no stiffness",
            ));
        }
        (RawKind::Fixed, None, None) => None,
        (RawKind::Tied, young, _) => {
            let last = if young.is_none() { "young" } else { "margin" };
            return Err(invalid(
                key(last),
                "nothing",
                "with kind = \"tied\": young and margin of what is between",
            ));
        }
        (RawKind::Fixed, young, _) => {
            let last = if young.is_some() { "young" } else { "margin" };
            return Err(invalid(
                key(last),
                "a number",
                "nothing with kind = \"fixed\", or kind = \"tied\"",
            ));
        }
    };
    Ok(Attachment {
        organ,
        to,
        within: length(&key("within"), raw.within)?,
        stiffness: tied.map(|t| t.1),
        young: tied.map(|t| t.0),
    })
}
