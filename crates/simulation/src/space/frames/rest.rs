//! Back to the state at the start, where the tube is in nothing: tissue that no tube touches lies as before any did.

use nalgebra::Isometry3;

use super::mix::Mix;
use super::report::Frame;
use super::search::Found;
use super::{Frames, Now, PART_OF_RADIUS};
use crate::space::tube::Tube;

/// A way of more parts than this is not looked at part by part.
const MOST_SEEN: f64 = 64.0;

impl Frames {
    /// Whether nothing presses on the tube.
    pub fn is_free(&self) -> bool {
        self.force().points == 0
    }

    /// What no point of the tube goes farther than on the way to a pose, mm.
    pub fn way_to(&self, pose: &Isometry3<f64>) -> f64 {
        self.tube().way_to(pose)
    }

    /// The tube at a pose at which it touches no surface of a state, and no solid holds it whole; `None` where it does, or the pose is none.
    fn clear(&self, pose: &Isometry3<f64>, a: &[f64]) -> Option<Tube> {
        let tube = self.now.tube.at(*pose).ok()?;
        let bodies = &self.system.bodies;
        let touches = (0..bodies.len()).any(|body| {
            let (solid, part) = (bodies.solid(body), bodies.part(body, a));
            (0..solid.points()).any(|point| tube.signed_distance(&solid.point(part, point)).value <= 0.0)
        });
        // Between its points it may be in a surface, or it is inside altogether.
        let inside = || self.look_inside(&tube, a).is_err();
        (!touches && !inside()).then_some(tube)
    }

    /// Whether a tube at a pose would touch nothing of the state at the start.
    pub fn is_clear(&self, pose: &Isometry3<f64>) -> bool {
        self.clear(pose, &self.begun.a).is_some()
    }

    /// Whether a tube at a pose would touch nothing of the state of the last frame.
    pub fn is_clear_now(&self, pose: &Isometry3<f64>) -> bool {
        self.clear(pose, &self.now.a).is_some()
    }

    /// Puts the tube to a pose without a way there, and the tissue to where it was at the start; `None`, and nothing is changed, where the tube
    /// would touch it there. That is the state of tissue that was never touched: where the tube has pushed it along to beyond its own
    /// place it is not, so ask for it where the tube is free, or where nobody knows how it came there.
    pub fn rest(&mut self, pose: &Isometry3<f64>) -> Option<Frame> {
        let tube = self.clear_at_start(pose)?;
        Some(self.rest_with(tube, pose))
    }

    /// The tube at a pose at which it touches nothing of the state at the start.
    pub(super) fn clear_at_start(&self, pose: &Isometry3<f64>) -> Option<Tube> {
        self.clear(pose, &self.begun.a)
    }

    /// At the start where nothing presses and the straight way there is clear of that, else as the tube moves tissue.
    pub(super) fn rest_or_frame(&mut self, pose: &Isometry3<f64>) -> Frame {
        let may_rest = self.is_free() && self.is_clear_on_the_way(pose);
        match may_rest.then(|| self.rest(pose)).flatten() {
            Some(frame) => frame,
            None => self.frame(pose),
        }
    }

    /// Whether the tube touches nothing of the state at the start where it is between two parts of the way to a pose: it is seen there as it would be walked.
    fn is_clear_on_the_way(&self, pose: &Isometry3<f64>) -> bool {
        let parts = self.way_to(pose) / (PART_OF_RADIUS * self.tube().least_radius());
        // Nobody walks farther, and no number is no way.
        if parts.is_nan() || parts > MOST_SEEN {
            return false;
        }
        let parts = parts.ceil() as usize;
        let between = (1..parts).map(|k| self.tube().toward(pose, k as f64 / parts as f64));
        between.into_iter().all(|tube| self.is_clear(tube.pose()))
    }

    /// At the start, with such a tube.
    pub(super) fn rest_with(&mut self, tube: Tube, pose: &Isometry3<f64>) -> Frame {
        self.frame += 1;
        if self.factors.take_up(self.frame) {
            self.ways[0] = self.ways[1];
        }
        let begun = self.begun.clone();
        self.restore(Now { tube, ..begun });
        (self.last, self.mix, self.scale, self.slow) = (None, Mix::default(), self.least_force(), false);
        let tube = &self.now.tube;
        let found = Found {
            gap: self.gap(tube, &self.now.a),
            inside: self.look_inside(tube, &self.now.a).unwrap_or(0.0),
            ..self.now.found
        };
        self.now.found = found;
        let state = self.judge(pose, &found);
        self.report(state, &found)
    }
}
