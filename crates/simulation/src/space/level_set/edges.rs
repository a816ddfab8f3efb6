//! A surface looked for round an organ only, with edges that are thinner than the ball left unproved.
//!
//! # What is proved
//!
//! A point of the organ's surface that was at `X` and is at `x` is led from one to the other along a straight line, all points at once. Where no such line, as
//! wide as the surface's points are apart, comes to an edge that the ball does not fit behind, and none is longer than what was looked at round
//! `X`, then on this whole way the organ's surface has met no edge and nothing unknown: they are outside of it as they were at rest.

use std::sync::Arc;

use nalgebra::Vector3;

use super::{LevelSet, NoSurface, SPACING, Tree, cover, foot};
use crate::space::cells::Curved;
use crate::space::gap::{seen_from, widest_on_the_way};

/// Round the organ's reach as much is looked at as feet and balls of what is within it may need, in radii.
const BEYOND: f64 = 2.0;

/// What of a surface is not proved, as the ball does not fit behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOut {
    /// Of the surface, mm^2.
    pub area: f64,
    /// The least distance of a point of it from a point of the organ at rest, mm.
    pub apart: f64,
    /// Where that is.
    pub at: [f64; 3],
}

/// Why a state is not proved to be clear of what was left out.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Unproved {
    /// It went farther than the surface was looked for.
    #[error(
        "a point of the surface is {moved:.2} mm from its place at rest: what is rigid was looked for {reach:.2} mm round that, and points are {gap:.2} mm from the middle between them"
    )]
    Beyond {
        /// How far, mm.
        moved: f64,
        /// How far it was looked for, mm.
        reach: f64,
        /// Half of the way to the next point, mm.
        gap: f64,
    },
    /// It is at an edge, or its way led over one.
    #[error(
        "a point of the surface is, or was on its way, {apart:.2} mm from an edge of what is rigid that is thinner than its ball; up to {gap:.2} mm it may lie between points unseen"
    )]
    Edge {
        /// How near, mm.
        apart: f64,
        /// Half of the way to the next point, mm.
        gap: f64,
    },
}

/// Where a surface was looked for, and what of it is not proved.
#[derive(Debug)]
pub(super) struct Looked {
    reach: f64,
    /// Its points behind which the ball does not fit.
    edges: Tree,
    left_out: Option<LeftOut>,
}

impl LevelSet {
    /// The surface of a field within `reach`, mm, of points of an organ's surface at rest. Where a ball of `radius` does not fit behind it, it is there and keeps the
    /// organ out, but what comes to it is [`Self::unproved`]; [`Self::left_out`] says how much that is. Farther off the distance may be to what is no nearest point.
    ///
    /// # Errors
    /// [`NoSurface`], but for `Thin`; `Empty` where nothing of it is so near.
    pub fn about(field: Arc<dyn Curved>, organ: &[Vector3<f64>], reach: f64, radius: f64) -> Result<Self, NoSurface> {
        if !(radius.is_finite() && radius > 0.0) {
            return Err(NoSurface::Radius { found: radius });
        }
        let bound =
            |one: fn(&Vector3<f64>, &Vector3<f64>) -> Vector3<f64>| organ.iter().copied().reduce(|a, b| one(&a, &b));
        let (Some(low), Some(high)) = (bound(Vector3::inf), bound(Vector3::sup)) else {
            return Err(NoSurface::Empty);
        };
        // why: a point within reach may be nearest to a part that lies a ball's width farther on.
        let far = reach + BEYOND * radius;
        let corners = [low.add_scalar(-far), high.add_scalar(far)];
        if !corners.iter().flatten().all(|x| x.is_finite()) || far <= 0.0 {
            let [low, high] = corners.map(Into::into);
            return Err(NoSurface::Box { low, high });
        }
        let organ = Tree::new(organ.to_vec());
        // By its middle and half its diagonal: no part of a box that is passed over is within reach.
        let is_wanted = |low: &Vector3<f64>, high: &Vector3<f64>| {
            let within = far + 0.5 * (high - low).norm();
            organ.apart_within(&(0.5 * (low + high)), within) < within
        };
        let (parts, cover) = cover::parts(field.as_ref(), corners, SPACING * radius, &is_wanted)?;
        let mut set = Self {
            feet: Arc::new(Tree::new(parts.iter().map(|part| part.foot).collect())),
            cover,
            field,
            corners,
            radius,
            looked: None,
        };
        // Asked of the whole set: whether the ball fits depends on all parts around.
        set.looked = Some(Arc::new(set.looked(&organ, reach, &parts)));
        Ok(set)
    }

    /// Which of its parts the ball does not fit behind. Those that no point within reach comes to are not asked: what is behind them may not be known.
    fn looked(&self, organ: &Tree, reach: f64, parts: &[cover::Part]) -> Looked {
        // why: a part stands for what lies as far from its foot as the cover; nearer to the organ than that it may still come.
        let most = reach + self.cover;
        let near = |part: &&cover::Part| organ.apart_within(&part.foot, most) < most;
        let thin = parts.iter().filter(near).filter(|part| !self.holds_ball(&part.foot));
        let mut left_out: Option<LeftOut> = None;
        let mut edges = Vec::new();
        for part in thin {
            edges.push(part.foot);
            let apart = organ.apart_within(&part.foot, most);
            let area = part.area(&foot::unit(&self.field.slope(&part.foot)));
            // Told together: the area of all, and the place of the one that is nearest.
            let before = left_out.unwrap_or(LeftOut {
                area: 0.0,
                apart: f64::INFINITY,
                at: part.foot.into(),
            });
            left_out = Some(LeftOut {
                area: before.area + area,
                apart: before.apart.min(apart),
                at: if apart < before.apart {
                    part.foot.into()
                } else {
                    before.at
                },
            });
        }
        Looked {
            reach,
            edges: Tree::new(edges),
            left_out,
        }
    }

    /// What of the surface within reach is not proved; `None` where all of it is.
    pub fn left_out(&self) -> Option<LeftOut> {
        self.looked.as_ref().and_then(|looked| looked.left_out)
    }

    /// Why the surface is not proved for a point of an organ's surface that was at `from` at rest and is at `to`. `gap` is half of the way to the next point, mm, as the surface is
    /// stretched there, and is asked where something is nearer than `most`; what is farther off is not between points.
    pub fn unproved(&self, [from, to]: [&Vector3<f64>; 2], most: f64, gap: &dyn Fn() -> f64) -> Option<Unproved> {
        let looked = self.looked.as_ref()?;
        let (moved, reach) = ((to - from).norm(), looked.reach);
        // What is no number is nowhere: the search itself says that.
        if moved + most > reach {
            let gap = gap();
            if moved + gap > reach {
                return Some(Unproved::Beyond { moved, reach, gap });
            }
        }
        let apart = looked.apart([*from, *to], most + self.cover, self.cover) - self.cover;
        if apart >= most {
            return None;
        }
        let gap = gap();
        (apart <= gap).then_some(Unproved::Edge { apart, gap })
    }
}

impl LevelSet {
    /// The same of a point where it is at rest, half of the way to the next of which is `gap`, mm.
    pub fn unproved_at_rest(&self, at: &Vector3<f64>, gap: f64) -> Option<Unproved> {
        self.unproved([at, at], seen_from(self.radius, gap), &|| widest_on_the_way(gap, 1.0))
    }
}

impl Looked {
    /// The distance of the edges from a line, less by `fine` at most, or `most` where none is nearer.
    fn apart(&self, line: [Vector3<f64>; 2], most: f64, fine: f64) -> f64 {
        let (mut waiting, mut least) = (vec![line], most);
        if self.edges.points().is_empty() {
            return most;
        }
        while let Some([from, to]) = waiting.pop() {
            let (middle, half) = (0.5 * (from + to), 0.5 * (to - from).norm());
            let apart = self.edges.apart_within(&middle, least + half) - half;
            if apart >= least {
                continue;
            }
            match half > 0.5 * fine {
                true => waiting.extend([[from, middle], [middle, to]]),
                false => least = apart,
            }
        }
        least
    }
}
