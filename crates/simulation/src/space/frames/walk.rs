//! The way to a pose: in parts where it is long, from where the last frames lead to, with factors that are new enough.

use nalgebra::Isometry3;

use super::search::Found;
use super::{Evaluated, Frames, Now, Refused};
use crate::space::tube::Tube;

/// Steps in a part of a way that does not end there: it only has to lead on.
const STEPS_ON_THE_WAY: usize = 4;
/// A residual that is better not left: a frame that ends with it is tried again in halves.
const FAR_OFF: f64 = 0.05;

impl Frames {
    /// Back to a state: factors may be of any other by now.
    pub(super) fn restore(&mut self, start: Now) {
        (self.now, self.ways, self.stale) = (start, [f64::INFINITY; 2], true);
    }

    /// Goes to a pose, and once more in halves where that leads nowhere: each half with factors of its own.
    pub(super) fn go(&mut self, pose: &Isometry3<f64>, parts: usize, start: &Now) -> Result<Found, Refused> {
        let first = self.walk(pose, parts, parts > 1);
        let good = first.as_ref().is_ok_and(|found| found.residual <= FAR_OFF);
        if good || parts > 1 || self.settings.most_parts < 2 {
            return first;
        }
        // The first way's end is kept: the halves may lead to a worse one.
        let reached = self.now.clone();
        self.restore(start.clone());
        match (first, self.walk(pose, 2, true)) {
            (Ok(first), Ok(second)) if second.residual < first.residual => Ok(first.and(&second)),
            (Ok(first), _) => {
                self.restore(reached);
                Ok(first)
            }
            (Err(_), second) => second,
        }
    }

    /// Goes to a pose in so many parts, of which so many are made as a frame may have; where `at_once`, with new factors in each.
    fn walk(&mut self, pose: &Isometry3<f64>, parts: usize, at_once: bool) -> Result<Found, Refused> {
        let mut found = Found::default();
        for part in 0..parts.min(self.settings.most_parts) {
            let left = parts - part;
            // A part of one is the pose itself, to the bit.
            let next = match left {
                1 => self.now.tube.at(*pose).map_err(|_| Refused::Pose)?,
                _ => self.now.tube.toward(pose, 1.0 / left as f64),
            };
            let most = if left == 1 {
                self.settings.most_steps
            } else {
                STEPS_ON_THE_WAY
            };
            self.refresh(at_once);
            let moved = self.now.tube.way_to(next.pose());
            self.ways.iter_mut().for_each(|way| *way += moved);
            if parts == 1 {
                self.foresee(&next);
            }
            found = found.and(&self.search(&next, most)?);
        }
        Ok(found)
    }

    /// Goes on as the last frame did, where that lowers energy and depths at the tube's new place: what is left is of second order then.
    fn foresee(&mut self, next: &Tube) {
        let Some(last) = &self.last else {
            return;
        };
        let (from, now, to) = (last.tube.pose(), self.now.tube.pose(), next.pose());
        let old = now.translation.vector - from.translation.vector;
        let part = (to.translation.vector - now.translation.vector).dot(&old) / old.norm_squared();
        let turn = from.rotation.rotation_to(&now.rotation).powf(part) * now.rotation;
        let foreseen = Isometry3::from_parts((now.translation.vector + old * part).into(), turn);
        // Back and forth along one way are foreseen, up to twice as fast, turns with it.
        if !(part.abs() <= 2.0 && next.way_to(&foreseen) <= 0.5 * next.way_to(now)) {
            return;
        }
        let a: Vec<f64> = self
            .now
            .a
            .iter()
            .zip(&last.a)
            .map(|(a, b)| a + part * (a - b))
            .collect();
        let Some(at) = Evaluated::of(&self.system, &a) else {
            return;
        };
        let (mut v, mut moved) = (Vec::new(), Vec::new());
        self.contact.touches.take(&self.now.a, &mut v);
        self.contact.touches.take(&a, &mut moved);
        let around = self.around(next);
        let cost = |v: &[f64]| self.contact.cost(&self.now.pressures, v, &around);
        let way: Vec<f64> = moved.iter().zip(&v).map(|(moved, v)| moved - v).collect();
        // A guess is taken only where it is better than to begin where the last frame ended.
        let lower = at.energy + cost(&moved) < self.now.at.energy + cost(&v);
        if lower && !self.contact.passes(&v, &way, &around) {
            (self.now.a, self.now.at, self.stale) = (a, at, true);
        }
    }

    /// New factors where the old ones are too old: at once on a long way, else by the other thread.
    fn refresh(&mut self, at_once: bool) {
        // By way, not by frames: a tube at rest needs no new factors.
        let old = self.ways[0] > self.settings.refresh;
        if !(old || self.slow) {
            return;
        }
        let mut v = Vec::new();
        self.contact.touches.take(&self.now.a, &mut v);
        let points = self
            .contact
            .around(&self.now.pressures, &v, &self.around(&self.now.tube));
        // In free air nothing asks for them.
        if points.is_empty() {
            return;
        }
        if (at_once || self.settings.delay == 0) && old {
            self.renew();
        } else if !self.factors.is_waiting() {
            let due = self.frame.saturating_add(self.settings.delay.max(1) as u64);
            let pressing = points.iter().copied().filter(|k| self.now.pressures[*k] > 0.0);
            let pressing = pressing.collect();
            self.factors.ask(&self.system, &self.now.a, (points, pressing), due);
            self.ways[1] = 0.0;
        }
    }

    /// Factors of the state as it is, at once; false where there are none.
    pub(super) fn renew(&mut self) -> bool {
        // What the other thread makes is older than what is made now, but its memory is needed.
        self.factors.take_up(u64::MAX);
        // Where none can be made, as tissue is about to slip, the old one is all there is.
        let made = self.factors.make_now(&self.system, &self.now.a);
        if made {
            (self.ways, self.stale) = ([0.0; 2], false);
        }
        made
    }
}
