//! A scene whose every value has been checked, but for what the label map says.

use nalgebra::Vector3;
use simulation::law::{Law, Refused};
use simulation::space::cells::{Parts, Settings, Smoothing};
use simulation::space::law::Material;

use super::raw::{RawAttachment, RawKind, RawOrgan, RawParts, RawSpaceField, RawSpaceLaw, RawSpaceScene, Triple};
use super::way::Way;
use crate::scene::{Checked, invalid, named, positive, short_name, within};

/// The most of each table.
const MOST_ORGANS: usize = 16;
const MOST_RIGID: usize = 64;
const MOST_LABELS: usize = 256;
const MOST_ATTACHMENTS: usize = 64;
/// Cubes of an organ: a scene must not ask for hours without a word.
const MOST_CUBES: usize = 20_000;
/// Lengths in a scene are no longer than a patient, mm.
pub(super) const LONGEST: f64 = 2000.0;
/// A tube that names no length, mm.
const LENGTH: f64 = 200.0;
/// The most states.
const MOST_STATES: f64 = 500.0;
/// From this Poisson's ratio on, conditions of the systems exceed what was tried.
const MOST_POISSON: f64 = 0.4999;

/// An organ.
#[derive(Debug, Clone)]
pub(super) struct Organ {
    pub(super) name: String,
    pub(super) label: u16,
    pub(super) material: Material,
    pub(super) smoothing: Smoothing,
    pub(super) settings: Settings,
    /// Of each halving: how near to the axis of the tube's way, mm.
    pub(super) within: Vec<f64>,
}

/// Labels that do not move.
#[derive(Debug, Clone)]
pub(super) struct Rigid {
    pub(super) name: String,
    pub(super) labels: Vec<u16>,
}

/// What holds an organ.
#[derive(Debug, Clone)]
pub(super) struct Attachment {
    pub(super) organ: usize,
    /// Numbers of [`Rigid`]s.
    pub(super) to: Vec<usize>,
    pub(super) within: f64,
    /// Stress by length; `None`: nodes keep their place.
    pub(super) stiffness: Option<f64>,
}

/// A soft bath.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bath {
    /// Stress by length.
    pub(super) stiffness: f64,
    pub(super) corridor: f64,
}

/// A scene whose values can be used.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub(super) organs: Vec<Organ>,
    pub(super) rigid: Vec<Rigid>,
    pub(super) attachments: Vec<Attachment>,
    pub(super) bath: Option<Bath>,
    pub(super) way: Way,
    pub(super) most_steps: usize,
    pub(super) field: RawSpaceField,
    pub(super) size: [u32; 2],
    pub(super) strip: usize,
}

impl Plan {
    /// # Errors
    /// [`scene::Invalid`] with the key of the first value that cannot be used.
    pub(super) fn new(raw: &RawSpaceScene) -> Checked<Self> {
        crate::model::title(&raw.title)?;
        unit("units.length", &raw.units.length, "mm")?;
        unit("units.stress", &raw.units.stress, "N/mm2")?;
        within("organs", raw.organs.len(), 1..=MOST_ORGANS)?;
        within("rigid", raw.rigid.len(), 0..=MOST_RIGID)?;
        within("attachments", raw.attachments.len(), 0..=MOST_ATTACHMENTS)?;
        within("search.most_steps", raw.search.most_steps, 1..=100_000)?;
        within("output.size.0", raw.output.size[0] as usize, 200..=4000)?;
        within("output.size.1", raw.output.size[1] as usize, 200..=4000)?;
        within("output.strip", raw.output.strip, 0..=24)?;
        crate::model::names("organs", raw.organs.iter().map(|o| o.name.as_str()))?;
        crate::model::names("rigid", raw.rigid.iter().map(|r| r.name.as_str()))?;
        let organs: Vec<Organ> = raw.organs.iter().enumerate().map(organ).collect::<Checked<_>>()?;
        let rigid = rigid(raw, &organs)?;
        let attachments = raw.attachments.iter().enumerate();
        Ok(Self {
            attachments: attachments
                .map(|(k, one)| attachment(k, one, &organs, &rigid))
                .collect::<Checked<_>>()?,
            bath: raw.surroundings.map(|bath| -> Checked<_> {
                let young = positive("surroundings.young", bath.young)?;
                Ok(Bath {
                    stiffness: young / length("surroundings.margin", bath.margin)?,
                    corridor: length("surroundings.corridor", bath.corridor)?,
                })
            })
            .transpose()?,
            way: way(raw)?,
            most_steps: raw.search.most_steps,
            field: raw.output.field,
            size: raw.output.size,
            strip: raw.output.strip,
            organs,
            rigid,
        })
    }
}

/// Units are named, so that nobody takes others for granted.
fn unit(key: &str, found: &str, allowed: &str) -> Checked<()> {
    let good = found == allowed;
    good.then_some(())
        .ok_or_else(|| invalid(key, format!("{found:?}"), format!("{allowed:?}: a label map's places are mm, and forces are N")))
}

/// A length above 0.
fn length(key: &str, value: f64) -> Checked<f64> {
    let good = value > 0.0 && value <= LONGEST;
    good.then_some(value)
        .ok_or_else(|| invalid(key, value, format!("a length above 0, at most {LONGEST} mm")))
}

/// A place or a direction.
fn triple(key: &str, [x, y, z]: Triple) -> Checked<Vector3<f64>> {
    let good = [x, y, z].iter().all(|c| c.abs() <= 1e5);
    good.then(|| Vector3::new(x, y, z))
        .ok_or_else(|| invalid(key, format!("[{x}, {y}, {z}]"), "three numbers within 1e5: left, posterior, superior, mm"))
}

fn organ((k, raw): (usize, &RawOrgan)) -> Checked<Organ> {
    let key = |last: &str| format!("organs.{k}.{last}");
    if raw.label == 0 {
        return Err(invalid(key("label"), 0, "a label of the map, above 0: 0 is what has none"));
    }
    let law = match raw.law {
        RawSpaceLaw::StVenantKirchhoff => Law::StVenantKirchhoff,
        RawSpaceLaw::Linear => Law::Linear,
        RawSpaceLaw::NeoHookean => Law::NeoHookean,
        RawSpaceLaw::StableNeoHookean => Law::StableNeoHookean,
    };
    positive(&key("young"), raw.young)?;
    if raw.poisson > MOST_POISSON {
        return Err(invalid(key("poisson"), raw.poisson, format!("above -1, at most {MOST_POISSON}")));
    }
    let material = Material::new(law, raw.young, raw.poisson).map_err(|refused| match refused {
        Refused::Young { .. } => invalid(key("young"), refused, "a stiffness above 0, N/mm2"),
        _ => invalid(key("poisson"), refused, format!("above -1, at most {MOST_POISSON}")),
    })?;
    let good = (0.0..=100.0).contains(&raw.smoothing);
    good.then_some(())
        .ok_or_else(|| invalid(key("smoothing"), raw.smoothing, "0 to 100 mm"))?;
    let levels = raw.cubes.levels;
    within(&key("cubes.levels"), levels as usize, 0..=Settings::MOST_LEVELS as usize)?;
    if raw.cubes.within.len() != levels as usize {
        let allowed = format!("as many distances as levels, {levels}: of each halving, how near to the tube's way");
        return Err(invalid(key("cubes.within"), format!("{} numbers", raw.cubes.within.len()), allowed));
    }
    for (i, near) in raw.cubes.within.iter().enumerate() {
        length(&key(&format!("cubes.within.{i}")), *near)?;
    }
    Ok(Organ {
        name: raw.name.clone(),
        label: raw.label,
        material,
        smoothing: Smoothing {
            sigma: raw.smoothing,
            parts: match raw.parts {
                RawParts::Refuse => Parts::Refuse,
                RawParts::Largest => Parts::Largest,
            },
            fill_holes: raw.fill_holes,
        },
        settings: Settings {
            levels,
            most_cubes: MOST_CUBES,
            ..Settings::of_side(length(&key("cubes.side"), raw.cubes.side)?)
        },
        within: raw.cubes.within.clone(),
    })
}

/// Labels that do not move; each label is of one table only.
fn rigid(raw: &RawSpaceScene, organs: &[Organ]) -> Checked<Vec<Rigid>> {
    let mut seen = std::collections::BTreeMap::new();
    for (k, organ) in organs.iter().enumerate() {
        if let Some(other) = seen.insert(organ.label, organ.name.as_str()) {
            return Err(invalid(format!("organs.{k}.label"), format!("{}, which is {other:?} already", organ.label), "a label of its own"));
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
                return Err(invalid(key, format!("{label}, which is {other:?} already"), "a label of its own"));
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

fn attachment(k: usize, raw: &RawAttachment, organs: &[Organ], rigid: &[Rigid]) -> Checked<Attachment> {
    let key = |last: &str| format!("attachments.{k}.{last}");
    let organ = named(&key("organ"), &raw.organ, organs.iter().map(|o| o.name.as_str()))?;
    within(&key("to"), raw.to.len(), 1..=MOST_RIGID)?;
    let to = raw.to.iter().enumerate();
    let to = to.map(|(i, name)| named(&key(&format!("to.{i}")), name, rigid.iter().map(|r| r.name.as_str())));
    let stiffness = match (raw.kind, raw.young, raw.margin) {
        (RawKind::Tied, Some(young), Some(margin)) => {
            Some(positive(&key("young"), young)? / length(&key("margin"), margin)?)
        }
        (RawKind::Fixed, None, None) => None,
        (RawKind::Tied, young, _) => {
            let last = if young.is_none() { "young" } else { "margin" };
            return Err(invalid(key(last), "nothing", "with kind = \"tied\": young and margin of what is between"));
        }
        (RawKind::Fixed, young, _) => {
            let last = if young.is_some() { "young" } else { "margin" };
            return Err(invalid(key(last), "a number", "nothing with kind = \"fixed\", or kind = \"tied\""));
        }
    };
    short_name(&key("organ"), &raw.organ)?;
    Ok(Attachment {
        organ,
        to: to.collect::<Checked<_>>()?,
        within: length(&key("within"), raw.within)?,
        stiffness,
    })
}

fn way(raw: &RawSpaceScene) -> Checked<Way> {
    let tube = &raw.tube;
    let entry = triple("tube.entry", tube.entry)?;
    let (key, along) = match (tube.target, tube.direction) {
        (Some(target), None) => ("tube.target", triple("tube.target", target)? - entry),
        (None, Some(direction)) => ("tube.direction", triple("tube.direction", direction)?),
        (Some(_), Some(_)) => return Err(invalid("tube.direction", "both", "target or direction, not both")),
        (None, None) => return Err(invalid("tube", "neither target nor direction", "one of them")),
    };
    let direction = along
        .try_normalize(1e-6)
        .ok_or_else(|| invalid(key, "no direction", "a place other than the entry, or a direction of some length"))?;
    let radius = 0.5 * length("tube.diameter", tube.diameter)?;
    let stroke = length("tube.stroke", tube.stroke)?;
    let step = length("tube.step", tube.step)?;
    // A point may be half a radius deep and no deeper: at once it is the step.
    if step >= 0.5 * radius {
        let allowed = format!("less than {} mm, a quarter of the diameter: more at once might pass through tissue", 0.5 * radius);
        return Err(invalid("tube.step", format!("{step} mm"), allowed));
    }
    if stroke / step > MOST_STATES {
        return Err(invalid("tube.step", step, format!("at least {} mm: at most {MOST_STATES} states", stroke / MOST_STATES)));
    }
    Ok(Way {
        entry,
        direction,
        radius,
        length: length("tube.length", tube.length.unwrap_or(LENGTH))?,
        stroke,
        step,
    })
}
