//! The images as they stand on the screen.

use bus::message::{FrameHeader, FrameState};
use geometry::{SlicePlane, letters};
use scene::{Extent, Plane, View};

use super::state::age_words;
use super::{Known, ScreenState, Tone};

/// One image.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Index of its view in the scene's list.
    pub view: usize,
    /// For people, and its name in the accessibility tree.
    pub title: String,
    /// Whether it shows the whole body or what lies before the tip.
    pub extent: Extent,
    /// It is the overview, which can be turned.
    pub is_surface: bool,
    /// Columns and rows; `None` where there is no image.
    pub size: Option<[u32; 2]>,
    /// Letters of the patient's directions at left, right, top and bottom; `None` where the image has no place in the patient.
    pub letters: Option<[String; 4]>,
    /// Side of a pixel, mm.
    pub pixel_mm: Option<f64>,
    /// Words that lie over the image, which is then dimmed: why it is not to be followed.
    pub over: Option<(Tone, String)>,
}

/// The images, in the order of the screen: local ones first, the perpendicular one last.
pub fn cells(known: &Known<'_>, state: &ScreenState) -> Vec<Cell> {
    let mut order: Vec<usize> = (0..known.scene.views.len()).collect();
    order.sort_by_key(|&index| {
        let view = &known.scene.views[index];
        (view.plane == Plane::Perpendicular, view.extent == Extent::Global)
    });
    order.into_iter().map(|index| cell(known, index, state)).collect()
}

fn cell(known: &Known<'_>, index: usize, state: &ScreenState) -> Cell {
    let header = known.headers.get(index).copied().flatten();
    let plane = header.as_ref().map(FrameHeader::slice_plane);
    let placed = plane.clone().and_then(Result::ok).flatten();
    let is_bad = matches!(plane, Some(Err(_)));
    Cell {
        view: index,
        title: title(&known.scene.views[index]),
        extent: known.scene.views[index].extent,
        is_surface: known.scene.views[index].plane == Plane::Surface,
        size: header.map(|header| [header.width, header.height]),
        letters: placed.as_ref().map(sides),
        pixel_mm: placed.as_ref().map(SlicePlane::pixel_mm),
        over: over(known, header.as_ref(), is_bad, state),
    }
}

/// Why the image is not to be followed, at this moment.
fn over(known: &Known<'_>, header: Option<&FrameHeader>, is_bad: bool, screen: &ScreenState) -> Option<(Tone, String)> {
    let Some(header) = header else {
        return Some((Tone::Alarm, "NO IMAGE".to_owned()));
    };
    if is_bad {
        return Some((Tone::Alarm, "IMAGE WITHOUT A PLACE".to_owned()));
    }
    let age = known.now_ns.saturating_sub(header.stamp.t_capture_ns);
    match header.stamp.state_at(known.now_ns, known.ages()) {
        Some(FrameState::Lost(_)) if known.standing_still() > 0 => {
            Some((Tone::Alarm, format!("STANDS STILL, {} OLD", age_words(age))))
        }
        Some(FrameState::Lost(_)) => Some((Tone::Alarm, format!("NO POSE, {} OLD", age_words(age)))),
        Some(FrameState::Stale) => Some((Tone::Warning, format!("{} OLD", age_words(age)))),
        None => Some((Tone::Alarm, "UNKNOWN KIND OF IMAGE".to_owned())),
        // What is held is shown as it is.
        Some(_) if screen.follows || screen.is_held && screen.tone == Tone::Warning => None,
        // All of them are dimmed where the screen as a whole must not be followed.
        Some(_) => Some((screen.tone, screen.word.clone())),
    }
}

/// The letters at left, right, top and bottom, from the plane itself.
fn sides(plane: &SlicePlane) -> [String; 4] {
    let (right, down) = (plane.right(), plane.down());
    [-right, right, -down, down].map(letters)
}

fn title(view: &View) -> String {
    let extent = match view.extent {
        Extent::Global => "global",
        Extent::Local => "local",
    };
    format!("{} {extent}", view.plane.name().to_uppercase())
}
