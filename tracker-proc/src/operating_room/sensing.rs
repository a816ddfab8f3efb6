//! What the localizer sees of a marker, and where it believes to see it.

use std::f64::consts::PI;

use calib::pose::{Body, Emitter, Localizer, Sighting};
use geometry::{Direction, Frame, Point, Rigid, Tracker, Vector};
use scene::operating_room::{Faults, Sensor};

use super::sight::Capsule;
use chance::Chance;

/// The localizer at one capture.
pub(super) struct Sensing<'a> {
    sensor: &'a Sensor,
    noise: Localizer,
    hides: &'a [Option<Capsule>; 2],
    chance: Chance,
}

/// Which name each emitter has for the localizer.
#[derive(Debug, Clone, Copy)]
pub(super) enum Named<'a> {
    /// Its own.
    Truly,
    /// What these faults make of it.
    Wrongly(&'a Faults),
}

impl<'a> Named<'a> {
    /// The names at script time `t_s`.
    pub(super) fn with(faults: &'a Faults, t_s: f64) -> Self {
        if t_s < faults.from_s {
            Self::Truly
        } else {
            Self::Wrongly(faults)
        }
    }

    /// The name of an emitter, or `None` of one that does not shine.
    fn name(self, emitter: usize) -> Option<usize> {
        let Self::Wrongly(faults) = self else {
            return Some(emitter);
        };
        let named = match faults.swapped {
            Some([a, b]) if emitter == a => b,
            Some([a, b]) if emitter == b => a,
            _ => emitter,
        };
        (!faults.dead.contains(&emitter)).then_some(named)
    }
}

/// The noise of a scene's localizer. Deviations may be 0 here, which a weight could not be.
pub(super) fn noise(sensor: &Sensor) -> Localizer {
    Localizer {
        eye: Point::new(0.0, 0.0, 0.0),
        across_mm: sensor.across_mm,
        depth_mm: sensor.depth_mm,
        at_mm: sensor.at_mm,
        growth_across: sensor.growth_across,
        growth_depth: sensor.growth_depth,
        step_mm: sensor.quantisation_mm,
    }
}

impl<'a> Sensing<'a> {
    /// The capture of frame `seq`.
    pub(super) fn new(sensor: &'a Sensor, hides: &'a [Option<Capsule>; 2], seed: u64, seq: u64) -> Self {
        Self {
            sensor,
            noise: noise(sensor),
            hides,
            chance: Chance::new(seed, seq),
        }
    }

    /// The emitters of `body` that are seen, in its order, each with noise from three draws of its own.
    pub(super) fn sightings<F: Frame>(
        &self,
        body: &Body<F>,
        pose: Rigid<Tracker, F>,
        cone_rad: f64,
        draws: u64,
        named: Named<'_>,
    ) -> Vec<Sighting> {
        let one = |(index, emitter): (usize, &Emitter<F>)| {
            let name = named.name(index)?;
            let place = pose * emitter.place;
            let normal = emitter.normal.map(|normal| pose * normal);
            self.sees(place, normal, cone_rad).then(|| Sighting {
                emitter: name,
                place: self.measured(place, draws + 3 * index as u64),
            })
        };
        body.emitters().iter().enumerate().filter_map(one).collect()
    }

    /// Whether every eye sees an emitter at `place` that looks along `normal`.
    fn sees(&self, place: Point<Tracker>, normal: Option<Direction<Tracker>>, cone_rad: f64) -> bool {
        let origin = Point::new(0.0, 0.0, 0.0);
        let range = self.sensor.nearest_mm..=self.sensor.farthest_mm;
        let eye_sees = |&eye: &Point<Tracker>| {
            normal.is_none_or(|normal| in_cone(normal, eye - place, cone_rad))
                && !self
                    .hides
                    .iter()
                    .flatten()
                    .any(|in_the_way| in_the_way.hides(eye, place))
        };
        range.contains(&place.distance(origin))
            && in_cone(Direction::Z, place - origin, self.sensor.view_rad)
            && self.sensor.eyes.iter().all(eye_sees)
    }

    /// Where an emitter at `place` seems to be: normal noise from three draws, rounded to the localizer's steps.
    ///
    /// With z of unit covariance and the line of sight u, `a z + (d - a) u (u . z)` has covariance
    /// `a^2 I + (d^2 - a^2) u u^T`.
    fn measured(&self, place: Point<Tracker>, draw: u64) -> Point<Tracker> {
        let [across, depth] = self.noise.deviations_mm(place);
        let [x, y, z] = [0, 1, 2].map(|i| self.chance.normal(draw + i));
        let even = Vector::new(x, y, z);
        let mut off = even * across;
        if let Some(sight) = (place - self.noise.eye).direction() {
            off = off + sight * ((depth - across) * sight.vector().dot(even));
        }
        let step = self.sensor.quantisation_mm;
        let [x, y, z] = (place + off).mm().map(|mm| match step > 0.0 {
            true => (mm / step).round() * step,
            false => mm,
        });
        Point::new(x, y, z)
    }
}

/// Whether `way` is within `half_angle` of `axis`; pi lets every way in, whatever its rounding.
fn in_cone(axis: Direction<Tracker>, way: Vector<Tracker>, half_angle: f64) -> bool {
    half_angle >= PI || axis.vector().dot(way) >= half_angle.cos() * way.norm()
}
