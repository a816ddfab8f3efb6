//! Pictures of organs and tube: shaded surfaces, and cuts through the tube's tip. Each says that it shows a model.

mod cut;
mod frame;
mod lattice;
mod shape;
mod skin;
mod targets;
#[cfg(test)]
mod tests;

use geometry::SlicePlane;
use nalgebra::Vector3;
use organs::raw::RawSpaceField;
use picture::{Anchor, Canvas, Rgb};
use simulation::space::tube::Tube;

use super::errors::{Finer, Said};
use super::report::Whole;
use super::run::State;
use crate::draw::colour::Ramp;
use cut::Cut;
use lattice::{Lattice, Moved};
use skin::{Samples, Skin};

use super::run::{is_minimum, stability};
use crate::draw::view::short;

/// Samples along the largest side of an organ.
const STEPS: f64 = 48.0;
/// The side of each of three cuts, and of the pictures of strip and film, pixels.
const SIDE: u32 = 420;
const SMALL: u32 = 300;
/// Of the numbers of a state, this part lies within the colours: where stress is infinite it does not take them all.
const WITHIN: f64 = 0.99;

/// All that pictures of a run have in common.
pub(super) struct Album<'a> {
    whole: &'a Whole<'a>,
    skins: Vec<Skin>,
    lattices: Vec<Lattice>,
    ramp: Ramp,
}

impl<'a> Album<'a> {
    /// Of a run; colours are those of the state that asks for most.
    pub(super) fn new(whole: &'a Whole<'a>) -> Self {
        let (mut skins, mut lattices) = (Vec::new(), Vec::new());
        for (body, organ) in whole.model.bodies.iter().zip(&whole.plan.organs) {
            let samples = Samples::over(body, STEPS);
            let lattice = Lattice::new(body, organ.material, samples);
            skins.push(Skin::new(body, whole.labels, &samples, &lattice.values));
            lattices.push(lattice);
        }
        let mut album = Self {
            whole,
            skins,
            lattices,
            ramp: Ramp::from_zero(0.0),
        };
        let most = whole
            .run
            .states
            .iter()
            .filter(|s| s.found.is_some())
            .map(|s| album.largest(s));
        album.ramp = Ramp::from_zero(most.fold(0.0, f64::max));
        album
    }

    fn moved(&self, state: &State) -> Vec<Moved> {
        let model = self.whole.model;
        let each = self.lattices.iter().enumerate();
        each.map(|(k, lattice)| {
            let part = model.system.bodies.part(k, &state.a);
            lattice.moved(&model.bodies[k], part, self.whole.plan.field)
        })
        .collect()
    }

    /// The end of the colours for a state: the largest displacement, or what all but a hundredth of the stresses are below.
    fn largest(&self, state: &State) -> f64 {
        let mut all = Vec::new();
        for (lattice, moved) in self.lattices.iter().zip(self.moved(state)) {
            let inside = lattice
                .values
                .iter()
                .zip(moved.shown)
                .filter(|(value, shown)| **value < 0.0 && shown.is_finite());
            all.extend(inside.map(|(_, shown)| shown));
        }
        all.sort_by(f64::total_cmp);
        let within = match self.whole.plan.field {
            RawSpaceField::Displacement => 1.0,
            RawSpaceField::VonMises => WITHIN,
        };
        let at = (all.len() as f64 * within) as usize;
        all.get(at.min(all.len().saturating_sub(1))).copied().unwrap_or(0.0)
    }

    fn gone(&self, state: &State) -> f64 {
        self.whole.model.free + state.stroke
    }

    fn tube(&self, state: &State) -> Option<Tube> {
        self.whole.model.way.tube(self.gone(state)).ok()
    }

    /// Two axes of each of three cuts: along the tube twice, its tip down, and across it, the head up, as it looks ahead.
    fn axes(&self) -> [[Vector3<f64>; 2]; 3] {
        let along = self.whole.plan.way.direction;
        // A tube from above or below has no head up across it: there the front is.
        let above = if along.z.abs() < 0.9 {
            Vector3::z()
        } else {
            -Vector3::y()
        };
        let up = (above - along * above.dot(&along)).try_normalize(0.0).unwrap_or(above);
        let right = along.cross(&up);
        [[right, along], [up, along], [right, -up]]
    }

    fn cut(&self, state: &State, moved: &[Moved], which: usize, side: u32) -> Option<(Cut, SlicePlane)> {
        let Whole {
            plan, labels, model, ..
        } = self.whole;
        let middle = labels.patient(&model.way.middle(self.gone(state)));
        let plane = shape::plane(&self.skins, self.axes()[which], Some(middle), [side; 2])?;
        let organs: Vec<_> = self.lattices.iter().zip(moved).collect();
        Some((
            Cut::new(&plane, (plan, labels, model), &organs, &self.tube(state)?),
            plane,
        ))
    }

    /// The surfaces.
    pub(super) fn shape(&self, state: &State) -> Canvas {
        let [width, height] = self.whole.plan.size;
        let mut canvas = frame::canvas(width, height);
        let view = [width, height.saturating_sub(92).max(60)];
        if let Some(camera) = shape::camera(&self.skins, &self.whole.plan.way.direction, view) {
            let of = (self.whole.labels, self.whole.model);
            shape::draw(
                &mut canvas,
                of,
                &self.skins,
                &camera,
                &state.a,
                self.gone(state),
                [0, 78],
            );
        }
        self.captions(&mut canvas, state, "surfaces, the tube in blue");
        canvas
    }

    /// Three cuts through the middle of the tube's round tip.
    pub(super) fn cuts(&self, state: &State) -> Canvas {
        let mut canvas = frame::canvas(3 * (SIDE + 8) + 100, SIDE + 160);
        let (moved, marks) = (self.moved(state), targets::marks(self.whole, state));
        let radius = self.whole.plan.way.radius;
        let across = format!("across the tube, {radius} mm behind its tip, seen along it");
        let words = ["along the tube", "along the tube, turned by 90 degrees", &across];
        for (which, words) in words.into_iter().enumerate() {
            let corner = [which as u32 * (SIDE + 8), 104];
            if let Some((cut, plane)) = self.cut(state, &moved, which, SIDE) {
                canvas.paste(&cut.painted(&self.ramp), SIDE, corner[0], corner[1]);
                targets::draw(&mut canvas, &plane, corner.map(f64::from), &marks);
                frame::sides(&mut canvas, &plane, corner.map(f64::from), false);
            }
            canvas.text(
                [f64::from(corner[0]) + 8.0, 91.0],
                words,
                13.0,
                frame::QUIET,
                Anchor::Left,
            );
        }
        let (what, unit) = self.field();
        self.captions(&mut canvas, state, what);
        let left = f64::from(3 * (SIDE + 8) + 12);
        frame::bar(&mut canvas, &self.ramp, [left, 130.0, f64::from(SIDE) + 90.0], unit);
        let rigid = match self.whole.plan.contacts.is_empty() {
            true => "named rigid: holds, is no obstacle",
            false => "named rigid: holds, keeps out what a contact names",
        };
        let all = [
            (cut::AT_REST, "line: the organ's border at rest"),
            (cut::LEFT[0], "hatched: was organ at rest, nothing is known of it now"),
            (cut::RIGID, rigid),
            (cut::OTHER, "other labels: not modelled, drawn at rest"),
            (cut::OVERLAP, "overlap: of organs, or with the tube"),
            (cut::TUBE, "tube"),
        ];
        frame::legend(&mut canvas, [10.0, f64::from(SIDE) + 122.0], &all);
        canvas
    }

    /// The surfaces beside the first cut, small.
    pub(super) fn small(&self, state: &State) -> Canvas {
        let mut canvas = frame::canvas(2 * SMALL + 6, SMALL + 42);
        if let Some(camera) = shape::camera(&self.skins, &self.whole.plan.way.direction, [SMALL; 2]) {
            let of = (self.whole.labels, self.whole.model);
            shape::draw(
                &mut canvas,
                of,
                &self.skins,
                &camera,
                &state.a,
                self.gone(state),
                [0, 42],
            );
        }
        if let Some((cut, plane)) = self.cut(state, &self.moved(state), 0, SMALL) {
            canvas.paste(&cut.painted(&self.ramp), SMALL, SMALL + 6, 42);
            frame::sides(&mut canvas, &plane, [f64::from(SMALL) + 6.0, 42.0], true);
        }
        canvas.text([8.0, 12.0], "MODEL", 14.0, frame::MODEL, Anchor::Left);
        let (words, colour) = self.said(state);
        canvas.text([66.0, 12.0], &words, 13.0, colour, Anchor::Left);
        let colours = format!(
            "{}; colours 0 to {} {}",
            self.known_of(state),
            short(self.ramp.high),
            self.field().1
        );
        canvas.text([8.0, 31.0], &colours, 12.0, frame::QUIET, Anchor::Left);
        canvas
    }

    fn field(&self) -> (&'static str, &'static str) {
        match self.whole.plan.field {
            RawSpaceField::Displacement => ("displacement, mm", "mm"),
            RawSpaceField::VonMises => (
                "von Mises stress, N/mm2; 1 % of the volume is above the colours",
                "N/mm2",
            ),
        }
    }

    fn said(&self, state: &State) -> (String, Rgb) {
        let mut words = format!("{}, {:.1} mm in", state.label, state.stroke);
        let good = state.found.is_some_and(|found| is_minimum(&found));
        match state.found {
            Some(_) => words += &format!(", force on the tube {:.3} N", state.on_tube.force.norm()),
            None => words += ", no force",
        }
        if let Some(found) = state.found.filter(|found| !is_minimum(found)) {
            words += ", ";
            words += stability(&found);
        }
        (words, if good { frame::WORDS } else { frame::ALARM })
    }

    fn captions(&self, canvas: &mut Canvas, state: &State, what: &str) {
        canvas.text([10.0, 15.0], "MODEL", 17.0, frame::MODEL, Anchor::Left);
        canvas.text([76.0, 15.0], self.whole.title, 17.0, frame::WORDS, Anchor::Left);
        let (words, colour) = self.said(state);
        canvas.text([10.0, 38.0], &format!("{words}: {what}"), 14.0, colour, Anchor::Left);
        let contact = match self.whole.plan.contacts.is_empty() {
            true => "no friction, no contact but with the tube",
            false => "no friction, no contact but with the tube and what keeps organs out",
        };
        let words = format!("{}; {contact}", self.known());
        canvas.text([10.0, 60.0], &words, 13.0, frame::QUIET, Anchor::Left);
    }

    /// What is known of a state's errors, in a few words: they are looked for of the last one alone.
    fn known_of(&self, state: &State) -> &'static str {
        match self.whole.errors {
            Said::Found(errors) if errors.of == state.label => "errors: result.json",
            _ => "errors not known",
        }
    }

    /// What is known of errors.
    fn known(&self) -> String {
        let Said::Found(errors) = self.whole.errors else {
            return "errors of mesh and model are NOT KNOWN".to_owned();
        };
        let number = |x: Option<f64>| x.map_or("NOT KNOWN".to_owned(), |x| format!("{x:.2e} N"));
        let mesh = errors.finer.as_ref().ok().map(|found| Finer::stated(&found.by.force));
        format!(
            "last force: mesh some {}, model {} (1 sigma of the scene's numbers, linearised){}",
            number(mesh),
            number(errors.model.force_size),
            if errors.model.targets.iter().any(Option::is_some) {
                "; ellipses: model, 95 %"
            } else {
                ""
            }
        )
    }
}
