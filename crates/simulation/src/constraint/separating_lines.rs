//! Lines that keep a sample and an arc apart while both move.
//!
//! An arc lies in the triangle of its control points, and each half of it, cut anywhere, in that of its own. A direction `e` that keeps
//! every control point `c` of a half behind the sample `p`, `e . (p - c) > 0`, proves that they are apart. Along a step this falls by
//! `t e . (v_p - v_c)` and, where solids turn, by at most `t^2 / 2` times a bound of the second derivatives. Cut at the
//! point nearest to the sample, an arc that bends away lies behind the tangent there with both halves, however near the sample is;
//! of one that bends round the sample each half lies behind its own chord.

use nalgebra::Vector2;

use super::shape::box_distance;

/// How a sample lies to an arc.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facing {
    /// Unit vector from the arc to the sample.
    pub(super) direction: Vector2<f64>,
    /// Along it; below zero inside the solid, where that is allowed.
    pub(super) distance: f64,
    /// The arc's point that is nearest.
    pub(super) u: f64,
}

/// A step leaves this part of every distance.
pub(super) const LEFT_OF_DISTANCE: f64 = 0.1;

/// The control points of an arc from its nodes, or their derivatives from those of its nodes.
fn control(nodes: &[Vector2<f64>; 3]) -> [Vector2<f64>; 3] {
    [nodes[0], nodes[1] * 2.0 - (nodes[0] + nodes[2]) * 0.5, nodes[2]]
}

/// The control points of the two parts of an arc that is cut at `u`, which have the middle one in common.
fn halves(nodes: &[Vector2<f64>; 3], u: f64) -> [Vector2<f64>; 5] {
    let ([first, middle, last], part) = (control(nodes), 0.5 * (u + 1.0));
    let (before, after) = (first.lerp(&middle, part), middle.lerp(&last, part));
    [first, before, before.lerp(&after, part), after, last]
}

/// A sample and the nodes of an arc on their way.
pub(super) struct Pair<'a> {
    pub(super) point: Vector2<f64>,
    pub(super) velocity: Vector2<f64>,
    pub(super) nodes: &'a [Vector2<f64>; 3],
    pub(super) velocities: &'a [Vector2<f64>; 3],
    /// A box round the arc.
    pub(super) bounds: &'a [Vector2<f64>; 2],
    /// A bound of the second derivatives of both together.
    pub(super) swerve: f64,
    /// A bound of the relative speed in any direction.
    pub(super) speed: f64,
}

impl Pair<'_> {
    /// The part of a step, up to `most`, that the box of the arc alone says is free.
    pub(super) fn far(&self, depth: f64, most: f64) -> f64 {
        // Within the box nothing is known of the distance to the arc, not even that the depth is kept.
        let apart = box_distance(self.bounds, &self.point);
        if apart > 0.0 {
            ((1.0 - LEFT_OF_DISTANCE) * (apart + depth) / self.speed.max(f64::MIN_POSITIVE)).min(most)
        } else {
            0.0
        }
    }

    /// The same, by the direction across the arc's chord: without a search for the nearest point.
    pub(super) fn beside(&self, depth: f64, most: f64) -> f64 {
        let Some(e) = self.across(self.nodes[0], self.nodes[2], depth) else {
            return 0.0;
        };
        // The arc is no farther than its nodes.
        let nodes = self.nodes.iter().map(|node| (self.point - node).norm_squared());
        let distance = nodes.fold(f64::INFINITY, f64::min).sqrt();
        // Room is counted down to `-depth`; a tenth of it stays.
        let kept = LEFT_OF_DISTANCE * (distance + depth) - depth;
        let (places, speeds) = (control(self.nodes), control(self.velocities));
        self.behind(e, &places, &speeds, kept).min(most)
    }

    /// The largest part of a step, up to `most`, after which a tenth of the distance, and of the depth allowed, is left.
    pub(super) fn free(&self, facing: &Facing, depth: f64, most: f64) -> f64 {
        let room = (facing.distance + depth).max(0.0);
        let any_direction = (1.0 - LEFT_OF_DISTANCE) * room / self.speed.max(f64::MIN_POSITIVE);
        // Most pairs are far enough for this bound, which needs no lines.
        if any_direction >= most {
            return most;
        }
        let kept = LEFT_OF_DISTANCE * room - depth;
        let (places, speeds) = (halves(self.nodes, facing.u), halves(self.velocities, facing.u));
        let half = |k: usize| {
            let (places, speeds) = (&places[k..k + 3], &speeds[k..k + 3]);
            let tangent = self.behind(facing.direction, places, speeds, kept);
            if tangent >= most {
                return most;
            }
            let chord = self.across(places[0], places[2], depth);
            chord.map_or(tangent, |e| tangent.max(self.behind(e, places, speeds, kept)))
        };
        // Both halves must stay behind, but of the two proofs either is enough.
        half(0).min(half(2)).max(any_direction).min(most)
    }

    /// The part of a step up to which these control points stay so far behind the sample.
    fn behind(&self, e: Vector2<f64>, places: &[Vector2<f64>], speeds: &[Vector2<f64>], kept: f64) -> f64 {
        let one = |(place, speed): (&Vector2<f64>, &Vector2<f64>)| {
            let (gap, rate) = (e.dot(&(self.point - place)), e.dot(&(self.velocity - speed)));
            // Taylor's remainder: a second derivative of at most `swerve` takes at most `swerve t^2 / 2` off the gap.
            first_fall(gap - kept, rate, 0.5 * self.swerve)
        };
        places.iter().zip(speeds).map(one).fold(f64::INFINITY, f64::min)
    }

    /// Across a chord, to the sample's side. Where a depth is allowed, `None` from the inner side, on the left: going deeper is no way
    /// out.
    fn across(&self, first: Vector2<f64>, last: Vector2<f64>, depth: f64) -> Option<Vector2<f64>> {
        let chord = last - first;
        let across = Vector2::new(chord.y, -chord.x);
        let side = across.dot(&(self.point - first));
        if side < 0.0 && depth > 0.0 {
            return None;
        }
        (if side < 0.0 { -across } else { across }).try_normalize(0.0)
    }
}

/// The first `t > 0` at which `gap + rate t - bend t^2` is zero; zero where it begins below, or where a number is NaN.
pub(super) fn first_fall(gap: f64, rate: f64, bend: f64) -> f64 {
    // A NaN fails every comparison below, and with a bend of 0 the whole step would count as proved free.
    if gap <= 0.0 || (gap + rate + bend).is_nan() {
        return 0.0;
    }
    let root = (rate * rate + 4.0 * bend * gap).sqrt();
    // The form without cancellation for either sign of the rate.
    if rate <= 0.0 {
        let denominator = root - rate;
        if denominator > 0.0 {
            2.0 * gap / denominator
        } else {
            f64::INFINITY
        }
    } else if bend > 0.0 {
        (rate + root) / (2.0 * bend)
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::super::nearest::nearest;
    use super::super::shape::Shape;
    use super::*;

    #[test]
    fn a_gap_that_is_no_number_is_never_proved_to_stay_open() {
        for (gap, rate, bend) in [(f64::NAN, -1.0, 0.0), (1.0, f64::NAN, 0.0), (1.0, 1.0, f64::NAN)] {
            assert_eq!(first_fall(gap, rate, bend), 0.0);
        }
        assert_eq!(first_fall(1.0, -2.0, 0.0), 0.5);
    }

    /// Numbers in (-1, 1).
    fn numbers(mut state: u64) -> impl FnMut() -> f64 {
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// The part of a step that is proved free, of a sample that lies as it is and moves by `velocity` past an arc that moves by `velocities`.
    fn proved(
        arc: [Vector2<f64>; 3],
        point: Vector2<f64>,
        velocities: &[Vector2<f64>; 3],
        velocity: Vector2<f64>,
    ) -> [f64; 3] {
        let (shape, at) = (Shape::of_arcs(vec![arc]), nearest(&arc, point));
        let fastest = velocities.iter().map(|v| v.norm()).fold(0.0, f64::max);
        let pair = Pair {
            point,
            velocity,
            nodes: &arc,
            velocities,
            bounds: &shape.boxes[0],
            swerve: 0.0,
            speed: velocity.norm() + 1.25 * fastest,
        };
        let facing = Facing {
            direction: at.offset / at.distance,
            distance: at.distance,
            u: at.u,
        };
        [pair.far(0.0, 1.0), pair.beside(0.0, 1.0), pair.free(&facing, 0.0, 1.0)]
    }

    #[test]
    fn what_is_proved_leaves_a_tenth_of_the_distance() {
        let (mut next, mut whole) = (numbers(11), 0);
        for _ in 0..2000 {
            let mut place = |size: f64| Vector2::new(next(), next()) * size;
            let arc = [
                Vector2::new(-1.0, 0.0) + place(0.2),
                place(0.5),
                Vector2::new(1.0, 0.0) + place(0.2),
            ];
            let (point, velocity) = (place(1.0), place(1.0));
            let velocities = [place(1.0), place(1.0), place(1.0)];
            let distance = nearest(&arc, point).distance;
            for free in proved(arc, point, &velocities, velocity) {
                whole += usize::from(free == 1.0);
                for k in 0..=20 {
                    let t = free * f64::from(k) / 20.0;
                    let moved = std::array::from_fn(|n| arc[n] + velocities[n] * t);
                    let left = nearest(&moved, point + velocity * t).distance;
                    assert!(
                        left >= LEFT_OF_DISTANCE * distance - 1e-12,
                        "{arc:?} {point} at {t} of {free}: {left} of {distance}"
                    );
                }
            }
        }
        assert!(whole > 200, "{whole}");
    }

    #[test]
    fn what_is_inside_goes_no_deeper_than_allowed() {
        // The solid lies on the left of its arc: above it.
        let still = [Vector2::zeros(); 3];
        for bend in [0.0, 0.1, -0.1] {
            let arc = [Vector2::new(-1.0, 0.0), Vector2::new(0.0, bend), Vector2::new(1.0, 0.0)];
            let (point, depth) = (Vector2::new(0.0, bend + 0.01), 0.05);
            let shape = Shape::of_arcs(vec![arc]);
            let pair = Pair {
                point,
                velocity: Vector2::y(),
                nodes: &arc,
                velocities: &still,
                bounds: &shape.boxes[0],
                swerve: 0.0,
                speed: 1.0,
            };
            let facing = Facing {
                direction: -Vector2::y(),
                distance: -0.01,
                u: 0.0,
            };
            // It lies 0.01 deep, and 0.04 is left; a bound that leaves a tenth.
            assert!(pair.beside(depth, 1.0) <= 0.04, "{bend}");
            let free = pair.free(&facing, depth, 1.0);
            assert!(free > 0.03 && free <= 0.04, "{bend}: {free}");
        }
    }

    #[test]
    fn sliding_along_an_arc_is_not_slowed() {
        // Bent away from the sample, and round it; near the arc beside what it bends.
        let still = [Vector2::zeros(); 3];
        for bend in [0.2, -0.2] {
            let arc = [Vector2::new(-1.0, 0.0), Vector2::new(0.0, bend), Vector2::new(1.0, 0.0)];
            let point = Vector2::new(0.1, 0.99 * bend + 1e-4);
            let [_, _, along] = proved(arc, point, &still, Vector2::new(1e-2, 0.0));
            let [_, _, away] = proved(arc, point, &still, Vector2::new(0.0, 1.0));
            let [_, _, towards] = proved(arc, point, &still, Vector2::new(0.0, -1.0));
            // An arc that bends round the sample rises before it: by 4e-4 in this step, more than there is room for.
            assert!(along > if bend > 0.0 { 0.99 } else { 0.01 }, "{bend}: {along}");
            assert!(away == 1.0 && towards < 1.5e-4, "{bend}: {away} {towards}");
        }
    }

    #[test]
    fn the_first_fall_is_a_root() {
        for (gap, rate, bend) in [
            (1.0, -2.0, 0.0),
            (1.0, -2.0, 3.0),
            (1.0, 2.0, 3.0),
            (1e-9, -1.0, 1e3),
            (2.0, 0.0, 0.5),
        ] {
            let t = first_fall(gap, rate, bend);
            let terms: f64 = gap + f64::abs(rate * t) + bend * t * t;
            assert!(
                (gap + rate * t - bend * t * t).abs() <= 1e-15 * terms,
                "{gap} {rate} {bend}: {t}"
            );
        }
        assert_eq!(first_fall(0.0, 1.0, 0.0), 0.0);
        assert_eq!(first_fall(1.0, 0.0, 0.0), f64::INFINITY);
    }
}
