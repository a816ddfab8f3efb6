//! `registration = "surface"`: how the bone's surface is seen by ultrasound.

use super::at::At;
use super::error::PlanError;
use super::raw::RawDials;

/// How the bone's surface is seen by a tracked ultrasound probe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Which share of the hand's whole way over the patient it goes, from his right side to the left.
    pub share: f64,
    /// An image at each so many-th place of the way, which are 5 mm apart on the skin.
    pub every: usize,
    /// Deviation of the speed of sound from the one that the scanner reckons with, as a share of it.
    pub speed: f64,
    /// How far the landmarks of the rough guess are off, standard deviation along each axis, mm.
    pub guess_mm: f64,
    /// Images of the wires that the probe is calibrated by.
    pub wire_images: u64,
    /// How far the phantom of these wires stands from where it is told to stand, deviations along and about each axis: mm, degrees.
    pub phantom: [f64; 2],
}

/// The stratum's own, where it is registered so.
pub(super) fn surface(at: &At<'_>, own: &RawDials, all: &RawDials) -> Result<Option<Surface>, PlanError> {
    let by = own.registration.as_deref().or(all.registration.as_deref());
    match by.unwrap_or("beads") {
        "beads" if own.surface.is_some() => {
            return Err(at.wrong(
                "surface",
                "a table",
                "registration = \"surface\" must be said beside it",
            ));
        }
        "beads" => return Ok(None),
        "surface" => {}
        other => return Err(at.wrong("registration", other, "\"beads\" or \"surface\" is allowed")),
    }
    let (own, all) = (own.surface.unwrap_or_default(), all.surface.unwrap_or_default());
    let percent = at.within(
        "surface.speed_percent",
        [own.speed_percent, all.speed_percent],
        1.5,
        0.0..=5.0,
    )?;
    Ok(Some(Surface {
        share: at.within("surface.share", [own.share, all.share], 1.0, 0.1..=1.0)?,
        // At most 40.
        every: at.within("surface.every", [own.every, all.every], 3, 1..=40)? as usize,
        speed: percent / 100.0,
        guess_mm: at.within("surface.guess_mm", [own.guess_mm, all.guess_mm], 8.0, 0.0..=30.0)?,
        wire_images: at.within("surface.wire_images", [own.wire_images, all.wire_images], 60, 6..=500)?,
        phantom: [
            at.within("surface.phantom_mm", [own.phantom_mm, all.phantom_mm], 0.2, 0.0..=5.0)?,
            at.within(
                "surface.phantom_deg",
                [own.phantom_deg, all.phantom_deg],
                0.15,
                0.0..=5.0,
            )?,
        ],
    }))
}
