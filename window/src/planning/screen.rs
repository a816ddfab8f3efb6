//! The planning screen: from what is known to shapes, and from the pointer and keys to what a person wishes.

mod chart;
mod foot;
mod image;
mod keys;
mod marks;
mod panel;
mod pointer;
mod structures;

use bus::message::{FrameHeader, PlanWish};
use egui::{Rect, Ui, pos2, vec2};
use geometry::{Ct, Point, VolumeGrid};
use guidance::plan::{Concern, Editor, Plan};
use guidance::workflow::VolumeId;

use super::camera::{CUTS, Cut};
use super::desk::Desk;
use super::labels::Beside;
use super::placed::Placed;
use crate::model::{Model, Tone};
use crate::screen::Band;
use crate::screen::words::{self, Words};
use crate::sizes::{Screen, Sizes, smallest};

/// So much of the screen's width is the images' at most.
const IMAGES: f32 = 0.56;

/// What is known of the plan and its examination.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    /// The band at the top.
    pub(crate) model: &'a Model,
    /// The plan as it was told, with the changes that were asked for since.
    pub(crate) plan: &'a Plan,
    /// Whether some of these are not written yet.
    pub(crate) is_writing: bool,
    /// The id of its file.
    pub(crate) file_id: u64,
    /// How many changes can be taken back, and made again.
    pub(crate) depth: [u32; 2],
    /// What speaks against it.
    pub(crate) concerns: &'a [Concern],
    /// Where the examination lies.
    pub(crate) grid: &'a VolumeGrid,
    /// The HU at a point.
    pub(crate) hu: &'a dyn Fn(Point<Ct>) -> Option<i16>,
    /// Of each cut: the image that is there, and whether it shows the plane that is wanted.
    pub(crate) images: [Option<(FrameHeader, bool)>; 4],
    /// Outer diameter of the tube, mm.
    pub(crate) tube_mm: f64,
    /// The structures beside the selected way.
    pub(crate) beside: &'a Beside,
    /// The error of navigation, mm; `None`: not known.
    pub(crate) error_mm: Option<f64>,
}

/// What came of a frame.
#[derive(Debug)]
pub(crate) struct Outcome {
    /// What the person asks of the plan.
    pub(crate) wishes: Vec<PlanWish>,
    /// The plan with these made: what comes later in the same frame is wished of it.
    plan: Editor,
    /// A picture of the screen is to be written.
    pub(crate) shot: bool,
    /// Every piece of text.
    pub(crate) words: Words,
    /// Where the coded cell is to be painted.
    pub(crate) code: Option<Rect>,
}

impl Default for Outcome {
    fn default() -> Self {
        Self::of(&Plan::new(VolumeId([0; 32])))
    }
}

impl Outcome {
    fn of(plan: &Plan) -> Self {
        Self {
            wishes: Vec::new(),
            plan: Editor::new(plan.clone()),
            shot: false,
            words: Words::default(),
            code: None,
        }
    }

    fn wish(&mut self, wish: PlanWish) {
        if let PlanWish::Edit(edit) = &wish {
            // Who keeps the plan says what is wrong with a change.
            let _ = self.plan.edit(edit.clone());
        }
        self.wishes.push(wish);
    }
}

/// Where the images and the panel beside them stand.
struct Rooms {
    images: [Option<Rect>; 4],
    panel: Rect,
}

/// Lays the screen out, and takes what the person does.
pub(crate) fn show(ui: &mut Ui, known: &Known<'_>, desk: &mut Desk, screen: Screen) -> Outcome {
    let mut outcome = Outcome::of(known.plan);
    let Some(sizes) = Sizes::of(screen, CUTS.len()) else {
        words::too_small(ui, screen, smallest(CUTS.len()), &mut outcome.words);
        return outcome;
    };
    let band = Band {
        model: known.model,
        sizes: &sizes,
        note: (&desk.note, Tone::Warning),
    };
    outcome.code = Some(band.show(ui, &mut outcome.words));
    let rooms = rooms(&sizes, desk.enlarged);
    let cells: Vec<image::Cell> = CUTS
        .into_iter()
        .filter_map(|cut| Some(image::Cell::of(known, cut, rooms.images[cut.place()]?, &sizes)))
        .collect();
    let pointed = pointer::pointed(ui, &cells);
    keys::take(ui, known, desk, pointed, &mut outcome);
    for cell in &cells {
        pointer::take(ui, known, desk, cell, &mut outcome);
        image::show(ui, known, desk, cell, (&sizes, &mut outcome.words));
    }
    let beside = panel::Panel { known, pointed };
    beside.show(ui, desk, rooms.panel, (&sizes, &mut outcome.words));
    foot::show(ui, known, desk, &sizes, &mut outcome);
    outcome
}

/// The band alone, while there is nothing to plan in.
pub(crate) fn waiting(ui: &Ui, model: &Model, screen: Screen) -> Outcome {
    let mut outcome = Outcome::default();
    match Sizes::of(screen, CUTS.len()) {
        Some(sizes) => {
            let (sizes, note) = (&sizes, ("", Tone::Quiet));
            outcome.code = Some(Band { model, sizes, note }.show(ui, &mut outcome.words));
        }
        None => words::too_small(ui, screen, smallest(CUTS.len()), &mut outcome.words),
    }
    outcome
}

fn rooms(sizes: &Sizes, enlarged: Option<Cut>) -> Rooms {
    let (top, bottom) = (sizes.top.bottom(), sizes.foot.top());
    let (width, height) = (sizes.top.width(), bottom - top);
    let all = height.min(IMAGES * width).floor();
    let side = (all / 2.0).floor();
    let at = |k: usize| pos2(side * (k % 2) as f32, top + side * (k / 2) as f32);
    let images = CUTS.map(|cut| match enlarged {
        None => Some(Rect::from_min_size(at(cut.place()), vec2(side, side))),
        Some(large) if large == cut => Some(Rect::from_min_size(pos2(0.0, top), vec2(all, all))),
        Some(_) => None,
    });
    let panel = Rect::from_min_max(pos2(all, top), pos2(width, bottom));
    Rooms {
        images,
        panel: panel.shrink(sizes.gap),
    }
}

/// The plane of an image that may be pointed at; `None` where it has no place in the patient.
fn placed(header: &FrameHeader, rect: Rect) -> Option<Placed> {
    let plane = header.slice_plane().ok().flatten()?;
    Some(Placed { rect, plane })
}

#[cfg(test)]
mod tests;
