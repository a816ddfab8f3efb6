//! Which samples and arcs a step must keep apart.

use super::broad_phase::near_arcs;
use super::ccd::{self, Pairing, Track, Way};
use super::near::{outside_own, signed};
use super::nearest::nearest;
use super::samples::Samples;
use super::separating_lines::Facing;
use super::shape::Shape;
use crate::bodies::Bodies;
use crate::solid::Cursor;

/// The part of a step, at most 1, in which no sample comes deeper than `depth` into an arc that it keeps out of.
pub(super) fn reach(way: &Way<'_>, samples: Samples<'_>, depth: f64) -> f64 {
    let pairing = Apart {
        bodies: way.bodies,
        samples,
        depth,
    };
    ccd::pairs(way, depth, &pairing)
}

/// Which samples keep out of which arcs on the way of a step.
struct Apart<'a> {
    bodies: &'a Bodies,
    samples: Samples<'a>,
    /// How deep they may come.
    depth: f64,
}

impl Pairing for Apart<'_> {
    fn tracks(&self, swept: &[Shape]) -> Vec<Track> {
        let mut tracks = Vec::new();
        for [one, two] in near_arcs(swept, 0.0) {
            if !self.samples.meeting.of(one[0] as usize, two[0] as usize) {
                continue;
            }
            for [own, other] in [[one, two], [two, one]] {
                let (body, arc) = (own[0] as usize, own[1] as usize);
                let count = self.samples.count(self.bodies, body, arc);
                tracks.extend((0..count).map(|k| Track {
                    on: [body, other[0] as usize],
                    sample: Cursor {
                        arc,
                        u: f64::from(k) * 2.0 / f64::from(count) - 1.0,
                    },
                    arc: other[1] as usize,
                }));
            }
        }
        tracks
    }

    fn facing(&self, shapes: &[Shape], track: &Track) -> Option<Facing> {
        let ([first, second], nodes) = (track.on, &shapes[track.on[1]].arcs[track.arc]);
        let at = nearest(nodes, shapes[first].place(&track.sample));
        if first == second && !outside_own(self.bodies, first, nodes, [track.sample.arc, track.arc], &at) {
            return None;
        }
        // Behind a barrier no sample is inside: its distance needs no sign.
        if self.depth == 0.0 {
            return Some(Facing {
                direction: at.offset / at.distance,
                distance: at.distance,
                u: at.u,
            });
        }
        let (direction, distance) = signed(nodes, &at);
        // The far side of a solid is no concern of a sample that has not come through the near one.
        (distance > -2.0 * self.depth).then_some(Facing {
            direction,
            distance,
            u: at.u,
        })
    }
}
