//! A scene whose every value has been checked, but for what the label map says.

mod held;
mod law;
mod numbers;
mod organ;
mod spread;
mod target;

use simulation::law::Law;
use simulation::space::cells::{Settings, Smoothing};
use simulation::space::law::Material;

use super::raw::{RawSpaceField, RawSpaceScene};
use super::way::Way;
use crate::numbers::{Checked, invalid, names, title, within};
use held::{attachment, contact, rigid};
use numbers::{length, triple, unit};
use organ::organ;
use spread::young;
pub use spread::{Given, Uncertain};
pub use target::Wanted;
use target::targets;

/// The most of each table.
const MOST_ORGANS: usize = 16;
const MOST_RIGID: usize = 64;
const MOST_ATTACHMENTS: usize = 64;
const MOST_CONTACTS: usize = 64;
const MOST_TARGETS: usize = 64;
/// Lengths in a scene are no longer than a patient, mm.
pub(crate) const LONGEST: f64 = 2000.0;
/// A tube that names no length, mm.
const LENGTH: f64 = 200.0;
/// The most states.
const MOST_STATES: f64 = 500.0;

/// An organ.
#[derive(Debug, Clone)]
pub struct Organ {
    /// For people.
    pub name: String,
    /// Of the label map, above 0.
    pub label: u16,
    /// The law's name in a scene.
    pub law: &'static str,
    /// `[weight, exponent]` of each term where that is Ogden's.
    pub ogden: Option<Vec<[f64; 2]>>,
    /// Of stresses in N/mm^2.
    pub material: Material,
    /// Young's modulus of the material, N/mm^2.
    pub young: Given,
    /// Poisson's ratio of the material.
    pub poisson: Given,
    /// How the surface of its label is smoothed.
    pub smoothing: Smoothing,
    /// Of its cubes, mm.
    pub settings: Settings,
    /// Of each halving: how near to the axis of the tube's way, mm.
    pub within: Vec<f64>,
}

/// Labels that do not move.
#[derive(Debug, Clone)]
pub struct Rigid {
    /// For people.
    pub name: String,
    /// Of the label map, above 0.
    pub labels: Vec<u16>,
}

/// What holds an organ.
#[derive(Debug, Clone)]
pub struct Attachment {
    /// Number of the organ.
    pub organ: usize,
    /// Numbers of [`Rigid`]s.
    pub to: Vec<usize>,
    /// It holds as near as this to a voxel of theirs, mm.
    pub within: f64,
    /// Stress by length, N/mm^3; `None`: nodes keep their place.
    pub stiffness: Option<f64>,
    /// What the stiffness is made of: Young's modulus, N/mm^2.
    pub young: Option<Given>,
}

/// What keeps an organ out: it slides along it.
#[derive(Debug, Clone)]
pub struct Contact {
    /// Number of the organ.
    pub organ: usize,
    /// Numbers of [`Rigid`]s.
    pub with: Vec<usize>,
    /// Standard deviation of the smoothing of their surface, mm.
    pub smoothing: f64,
    /// Radius of a ball that fits behind it, mm.
    pub ball: f64,
}

/// What keeps an organ out is looked for so many strokes round it at rest: an organ that is pushed at its rim turns, and its other end goes farther than the tube. What goes
/// farther still is refused when it does.
const REACH: f64 = 1.5;
/// But no farther than so, mm: a tube that passes an organ by has a long stroke, and moves it by no more than it is wide.
const FARTHEST: f64 = 30.0;

impl Contact {
    /// How far round the organ at rest it is looked for, mm, where the tube goes this far from its first touch on.
    pub fn reach(&self, stroke: f64) -> f64 {
        (REACH * stroke).min(FARTHEST) + self.ball
    }
}

/// A soft bath.
#[derive(Debug, Clone, Copy)]
pub struct Bath {
    /// Stress by length, N/mm^3.
    pub stiffness: f64,
    /// What the stiffness is made of: Young's modulus, N/mm^2.
    pub young: Given,
    /// Nearer than this to the axis of the tube's way there is none, mm.
    pub corridor: f64,
}

/// A scene whose values can be used.
#[derive(Debug, Clone)]
pub struct Plan {
    /// One at least, each of a label of its own.
    pub organs: Vec<Organ>,
    /// What does not move.
    pub rigid: Vec<Rigid>,
    /// What holds organs at that.
    pub attachments: Vec<Attachment>,
    /// What is rigid and keeps organs out.
    pub contacts: Vec<Contact>,
    /// What is around organs; `None`: nothing.
    pub bath: Option<Bath>,
    /// The tube's, in the patient: LPS, mm.
    pub way: Way,
    /// Places of organs that are told.
    pub targets: Vec<Wanted>,
    /// SHA-256 that the file of the label map must have, in lower case.
    pub labels_sha256: Option<String>,
    /// Whether errors are looked for.
    pub errors: bool,
    /// The most Newton steps of one search.
    pub most_steps: usize,
    /// What cuts show.
    pub field: RawSpaceField,
    /// Pixels of the picture of the shape: columns, rows.
    pub size: [u32; 2],
    /// How many states the strip shows, at most.
    pub strip: usize,
}

impl Plan {
    /// Checks every value that can be without the label map.
    ///
    /// # Errors
    /// [`scene::Invalid`] with the key of the first value that cannot be used.
    pub fn new(raw: &RawSpaceScene) -> Checked<Self> {
        title(&raw.title)?;
        unit("units.length", &raw.units.length, "mm")?;
        unit("units.stress", &raw.units.stress, "N/mm2")?;
        within("organs", raw.organs.len(), 1..=MOST_ORGANS)?;
        within("rigid", raw.rigid.len(), 0..=MOST_RIGID)?;
        within("attachments", raw.attachments.len(), 0..=MOST_ATTACHMENTS)?;
        within("contacts", raw.contacts.len(), 0..=MOST_CONTACTS)?;
        within("targets", raw.targets.len(), 0..=MOST_TARGETS)?;
        within("search.most_steps", raw.search.most_steps, 1..=100_000)?;
        within("output.size.0", raw.output.size[0] as usize, 200..=4000)?;
        within("output.size.1", raw.output.size[1] as usize, 200..=4000)?;
        within("output.strip", raw.output.strip, 0..=24)?;
        names("organs", raw.organs.iter().map(|o| o.name.as_str()))?;
        names("rigid", raw.rigid.iter().map(|r| r.name.as_str()))?;
        names("targets", raw.targets.iter().map(|t| t.name.as_str()))?;
        let organs: Vec<Organ> = raw.organs.iter().enumerate().map(organ).collect::<Checked<_>>()?;
        let rigid = rigid(raw, &organs)?;
        let attachments = raw.attachments.iter().enumerate();
        Self {
            attachments: attachments
                .map(|(k, one)| attachment(k, one, &organs, &rigid))
                .collect::<Checked<_>>()?,
            contacts: raw
                .contacts
                .iter()
                .enumerate()
                .map(|(k, one)| contact(k, one, &organs, &rigid))
                .collect::<Checked<_>>()?,
            bath: raw
                .surroundings
                .map(|bath| -> Checked<_> {
                    let young = young("surroundings", bath.young, bath.young_spread)?;
                    Ok(Bath {
                        stiffness: young.value / length("surroundings.margin", bath.margin)?,
                        young,
                        corridor: length("surroundings.corridor", bath.corridor)?,
                    })
                })
                .transpose()?,
            way: way(raw)?,
            targets: targets(raw, &organs)?,
            labels_sha256: raw.space.labels_sha256.as_deref().map(sha256).transpose()?,
            errors: raw.output.errors,
            most_steps: raw.search.most_steps,
            field: raw.output.field,
            size: raw.output.size,
            strip: raw.output.strip,
            organs,
            rigid,
        }
        .checked()
    }

    /// The labels of what is rigid, by its numbers.
    pub(crate) fn labels_of(&self, rigid: &[usize]) -> Vec<u16> {
        rigid
            .iter()
            .flat_map(|r| self.rigid[*r].labels.iter().copied())
            .collect()
    }

    /// The same of one organ.
    pub(crate) fn alone(&self, organ: usize) -> Self {
        let attachments = self.attachments.iter().filter(|one| one.organ == organ);
        let contacts = self.contacts.iter().filter(|one| one.organ == organ);
        Self {
            organs: vec![self.organs[organ].clone()],
            attachments: attachments
                .map(|one| Attachment {
                    organ: 0,
                    ..one.clone()
                })
                .collect(),
            contacts: contacts
                .map(|one| Contact {
                    organ: 0,
                    ..one.clone()
                })
                .collect(),
            ..self.clone()
        }
    }

    /// Its names, a comma between.
    pub(crate) fn names_of(&self, rigid: &[usize]) -> String {
        let names: Vec<&str> = rigid.iter().map(|r| self.rigid[*r].name.as_str()).collect();
        names.join(", ")
    }

    /// # Errors
    /// A field that is not what its name says.
    fn checked(self) -> Checked<Self> {
        // Elements of these laws carry part of the deviator by dilatations of their own, which a picture does not know.
        let wrong = |organ: &&Organ| matches!(organ.material.law, Law::Linear | Law::StVenantKirchhoff);
        match self.organs.iter().find(wrong) {
            Some(organ) if self.field == RawSpaceField::VonMises => Err(invalid(
                "output.field",
                format!("\"von-mises\", with the law {} of {:?}", organ.law, organ.name),
                "\"displacement\", or a law whose pressure is of the volume alone: neo-hookean, stable-neo-hookean, ogden",
            )),
            _ => Ok(self),
        }
    }
}

/// 64 hexadecimal digits, in lower case.
fn sha256(text: &str) -> Checked<String> {
    let good = text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit());
    good.then(|| text.to_ascii_lowercase()).ok_or_else(|| {
        invalid(
            "space.labels_sha256",
            format!("{text:?}"),
            "64 hexadecimal digits, as sha256sum prints them",
        )
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
    let direction = along.try_normalize(1e-6).ok_or_else(|| {
        invalid(
            key,
            "no direction",
            "a place other than the entry, or a direction of some length",
        )
    })?;
    let radius = 0.5 * length("tube.diameter", tube.diameter)?;
    let stroke = length("tube.stroke", tube.stroke)?;
    let step = length("tube.step", tube.step)?;
    // A point may be half a radius deep and no deeper: at once it is the step.
    if step >= 0.5 * radius {
        let allowed = format!(
            "less than {} mm, a quarter of the diameter: more at once might pass through tissue",
            0.5 * radius
        );
        return Err(invalid("tube.step", format!("{step} mm"), allowed));
    }
    if stroke / step > MOST_STATES {
        return Err(invalid(
            "tube.step",
            step,
            format!("at least {} mm: at most {MOST_STATES} states", stroke / MOST_STATES),
        ));
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
