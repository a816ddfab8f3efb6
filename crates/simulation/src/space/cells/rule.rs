//! Integrals over the part of a box inside a region, and over the region's surface within it.
//!
//! After Saye (2015, High-order quadrature methods for implicitly defined surfaces and volumes in hyperrectangles): along an
//! axis in which the field rises or falls throughout the box, its surface is the graph of a function of the other two. Of
//! the two faces across that axis the same is done in one dimension less, so that Gauss points lie between the places where
//! the integrand has kinks. A box without such an axis is cut into eight.

mod line;

use nalgebra::Vector3;

pub(super) use line::gauss;
use line::{pieces, root};

use super::field::{Bounds, Field};

/// A point inside with the volume that it stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inside {
    /// Where it is.
    pub at: Vector3<f64>,
    /// Volume, above 0.
    pub weight: f64,
}

/// A point of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Where it is.
    pub at: Vector3<f64>,
    /// Unit normal out of the region.
    pub normal: Vector3<f64>,
    /// Area that it stands for, above 0.
    pub area: f64,
}

/// How finely it is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Depth {
    /// Times that a box without an axis may be cut in eight, and a face of it in four.
    pub cuts: u32,
    /// Gauss points of each one-dimensional integral, 1 to 5.
    pub points: usize,
}

impl Default for Depth {
    /// Three cuts, four points: exact to degree 7 where the surface is smooth.
    fn default() -> Self {
        Self { cuts: 3, points: 4 }
    }
}

/// Points inside and on the surface.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rule {
    /// Inside.
    pub inside: Vec<Inside>,
    /// On the surface.
    pub surface: Vec<Surface>,
}

impl Rule {
    /// The rule of the box between two corners.
    pub fn of(field: &dyn Field, low: &Vector3<f64>, high: &Vector3<f64>, depth: Depth) -> Self {
        let mut build = Build {
            field,
            gauss: gauss(depth.points),
            depth,
            rule: Self::default(),
        };
        build.volume(*low, *high, depth.cuts);
        build.rule
    }

    /// Points of the surface alone, in a box between two corners.
    pub fn surface_of(field: &dyn Field, low: &Vector3<f64>, high: &Vector3<f64>, depth: Depth) -> Vec<Surface> {
        let [least, most] = field.bounds(low, high);
        // All of it is inside, or outside.
        if least >= 0.0 || most <= 0.0 {
            return Vec::new();
        }
        Self::of(field, low, high, depth).surface
    }

    /// Volume inside.
    pub fn volume(&self) -> f64 {
        self.inside.iter().map(|p| p.weight).sum()
    }

    /// Area of the surface.
    pub fn area(&self) -> f64 {
        self.surface.iter().map(|p| p.area).sum()
    }
}

/// A slope along the axis of height smaller than this part of the whole makes a poor graph: the box is cut instead.
const STEEP: f64 = 0.25;
/// Halvings of an edge in search of two roots near one another: missed ones cost the square of their distance.
const MOST_HALVES: u32 = 12;
/// Where the slope is less than this part of the largest in a box, the field is flat.
const FLAT: f64 = 0.1;

struct Build<'a> {
    field: &'a dyn Field,
    gauss: &'static [(f64, f64)],
    depth: Depth,
    rule: Rule,
}

impl Build<'_> {
    fn volume(&mut self, low: Vector3<f64>, high: Vector3<f64>, cuts: u32) {
        let [least, most] = self.field.bounds(&low, &high);
        if least >= 0.0 {
            return;
        }
        // Of a quarter of the box and less fewer points do as well.
        let made = (self.depth.cuts - cuts) as usize;
        self.gauss = gauss(
            self.depth
                .points
                .saturating_sub(made.saturating_sub(1))
                .max(self.depth.points.min(2)),
        );
        // No search where bounds decide: most boxes of a region are whole.
        if most <= 0.0 {
            return self.whole(&low, &high);
        }
        let cuts = if (high - low).max() <= self.field.resolution() {
            0
        } else {
            cuts
        };
        // A box that is still not the graph of a function is small: one rule over its base is enough.
        let found = self.height(&low, &high, false).map(|axis| (axis, self.depth.cuts));
        let found = found.or_else(|| {
            (cuts == 0)
                .then(|| self.height(&low, &high, true))
                .flatten()
                .map(|axis| (axis, 0))
        });
        match found {
            Some((axis, cuts)) => {
                let [a, b] = others(axis);
                // The field on the two faces across the axis.
                let faces = [low[axis], high[axis]].map(|at| vec![(axis, at)]);
                self.base(&low, &high, axis, [a, b], &faces, cuts);
            }
            None => {
                for part in 0..8 {
                    let [low, high] = eighth(&low, &high, part);
                    self.volume(low, high, cuts - 1);
                }
            }
        }
    }

    /// All of a box.
    fn whole(&mut self, low: &Vector3<f64>, high: &Vector3<f64>) {
        let side = high - low;
        for (z, wz) in self.gauss {
            for (y, wy) in self.gauss {
                for (x, wx) in self.gauss {
                    let at = low + side.component_mul(&Vector3::new(*x, *y, *z));
                    let weight = side.product() * wx * wy * wz;
                    self.rule.inside.push(Inside { at, weight });
                }
            }
        }
    }

    /// The axis along which the field rises or falls throughout, and steeply, the steepest of them; where `any`, the steepest
    /// of all.
    fn height(&self, low: &Vector3<f64>, high: &Vector3<f64>, any: bool) -> Option<usize> {
        let slope = self.field.slope(&((low + high) * 0.5));
        let steepest = |k: &usize, l: &usize| slope[*k].abs().total_cmp(&slope[*l].abs());
        if any {
            return (0..3).max_by(steepest);
        }
        let bounds = self.field.slope_bounds(low, high);
        let rising: Vec<usize> = (0..3).filter(|k| one_sign(bounds[*k])).collect();
        if rising.is_empty() {
            return None;
        }
        let steep = self.steep(low, high);
        rising.into_iter().filter(|k| steep[*k]).max_by(steepest)
    }

    /// For each axis whether the surface is the graph of a function that is not too steep: it would lose what area lies upright
    /// over its base. Looked at in 27 places; where the field is flat, no surface runs.
    fn steep(&self, low: &Vector3<f64>, high: &Vector3<f64>) -> [bool; 3] {
        let side = high - low;
        let place =
            |n: usize| low + side.component_mul(&Vector3::from([n % 3, n / 3 % 3, n / 9].map(|k| 0.5 * k as f64)));
        let slopes: Vec<Vector3<f64>> = (0..27).map(|n| self.field.slope(&place(n))).collect();
        let most = slopes.iter().map(Vector3::norm).fold(0.0, f64::max);
        let counted = slopes.iter().filter(|s| s.norm() > FLAT * most);
        counted.fold([true; 3], |steep, s| {
            let norm = s.norm();
            [0, 1, 2].map(|k| steep[k] && s[k].abs() > STEEP * norm)
        })
    }

    /// The integral over the two other axes.
    fn base(
        &mut self,
        low: &Vector3<f64>,
        high: &Vector3<f64>,
        axis: usize,
        [a, b]: [usize; 2],
        faces: &[Vec<(usize, f64)>],
        cuts: u32,
    ) {
        // The height of the column has a kink where the surface leaves it through a face. A face on which the field has one
        // sign has none.
        let kinks: Vec<_> = faces.iter().filter(|f| self.may_vanish(low, high, f)).collect();
        let Some(second) = self.second(low, high, [a, b], &kinks, cuts == 0) else {
            for part in 0..4 {
                let (mut low, mut high) = (*low, *high);
                for (k, axis) in [a, b].into_iter().enumerate() {
                    halve(&mut low, &mut high, axis, part >> k & 1 == 1);
                }
                self.base(&low, &high, axis, [a, b], faces, cuts - 1);
            }
            return;
        };
        let first = if second == a { b } else { a };
        let edges: Vec<Vec<(usize, f64)>> = kinks
            .iter()
            .flat_map(|face| [low[second], high[second]].map(|at| [face.as_slice(), &[(second, at)]].concat()))
            .collect();
        // The outer integral has kinks where the curves of the faces leave the base.
        let (mut at, mut stops) = (*low, vec![low[first], high[first]]);
        for edge in &edges {
            edge.iter().for_each(|(k, x)| at[*k] = *x);
            self.roots(&mut at, first, [low[first], high[first]], MOST_HALVES, &mut stops);
        }
        for (x, wx) in pieces(&mut stops, self.gauss) {
            let mut stops = vec![low[second], high[second]];
            for face in &kinks {
                face.iter().for_each(|(k, x)| at[*k] = *x);
                at[first] = x;
                self.roots(&mut at, second, [low[second], high[second]], 0, &mut stops);
            }
            for (y, wy) in pieces(&mut stops, self.gauss) {
                at[first] = x;
                at[second] = y;
                self.column(at, axis, [low[axis], high[axis]], wx * wy);
            }
        }
    }

    fn may_vanish(&self, low: &Vector3<f64>, high: &Vector3<f64>, fixed: &[(usize, f64)]) -> bool {
        let [least, most] = self.field.bounds(&with(low, fixed), &with(high, fixed));
        least < 0.0 && most > 0.0
    }

    /// Of two axes the one along which the field rises or falls on all the faces; where `any`, one in any case.
    fn second(
        &self,
        low: &Vector3<f64>,
        high: &Vector3<f64>,
        axes: [usize; 2],
        kinks: &[&Vec<(usize, f64)>],
        any: bool,
    ) -> Option<usize> {
        // How steep the flattest face is.
        let rated = axes.map(|k| {
            let each = kinks.iter().map(|face| {
                let (low, high) = (with(low, face), with(high, face));
                let slope = self.field.slope(&((low + high) * 0.5));
                let steep = slope[k].abs() / Vector3::new(slope[axes[0]], slope[axes[1]], 0.0).norm();
                let good = one_sign(self.field.slope_bounds(&low, &high)[k]) && steep > STEEP;
                if good { steep } else { -1.0 }
            });
            each.fold(f64::INFINITY, f64::min)
        });
        let best = usize::from(rated[1] > rated[0]);
        (any || rated[best] > 0.0).then_some(axes[best])
    }

    /// The inside of a column along an axis, and where it leaves the region.
    fn column(&mut self, mut at: Vector3<f64>, axis: usize, [low, high]: Bounds, weight: f64) {
        let mut value = |x: f64| {
            at[axis] = x;
            self.field.value(&at)
        };
        // The field rises or falls along the column: its ends tell all.
        let (bottom, top) = (value(low), value(high));
        let [from, to] = match (bottom < 0.0, top < 0.0) {
            (true, true) => [low, high],
            (false, false) => return,
            (inside, _) => {
                let root = root(&mut value, [low, high], [bottom, top]);
                self.cross(with(&at, &[(axis, root)]), axis, weight);
                if inside { [low, root] } else { [root, high] }
            }
        };
        for (z, wz) in self.gauss {
            at[axis] = from + (to - from) * z;
            let weight = weight * wz * (to - from);
            if weight > 0.0 {
                self.rule.inside.push(Inside { at, weight });
            }
        }
    }

    /// A point of the surface over an area `base` across an axis.
    fn cross(&mut self, at: Vector3<f64>, axis: usize, base: f64) {
        let slope = self.field.slope(&at);
        let length = slope.norm();
        let area = base * length / slope[axis].abs();
        // Where the slope vanishes there is no surface to speak of.
        if area.is_finite() && area > 0.0 {
            let normal = slope / length;
            self.rule.surface.push(Surface { at, normal, area });
        }
    }

    /// Adds the places along an axis where the field changes its sign; a part in which it may do so twice is halved.
    fn roots(&self, at: &mut Vector3<f64>, axis: usize, [low, high]: Bounds, halves: u32, found: &mut Vec<f64>) {
        let flat = |at: &Vector3<f64>, x: f64| with(at, &[(axis, x)]);
        let mut value = |x: f64| self.field.value(&flat(at, x));
        let ends = [value(low), value(high)];
        if (ends[0] < 0.0) != (ends[1] < 0.0) {
            found.push(root(&mut value, [low, high], ends));
            return;
        }
        // Ends alike: none, or two. Bounds cost more than values, and are asked for here only.
        let (from, to) = (flat(at, low), flat(at, high));
        let [least, most] = self.field.bounds(&from, &to);
        let may_vanish = least < 0.0 && most > 0.0;
        // Two roots as near to one another as a surface that touches an edge makes them: only parts that may hold them are halved.
        let halves = if high - low <= self.field.resolution() {
            0
        } else {
            halves
        };
        if halves > 0 && may_vanish && !one_sign(self.field.slope_bounds(&from, &to)[axis]) {
            let middle = 0.5 * (low + high);
            self.roots(at, axis, [low, middle], halves - 1, found);
            self.roots(at, axis, [middle, high], halves - 1, found);
        }
    }
}

fn others(axis: usize) -> [usize; 2] {
    [(axis + 1) % 3, (axis + 2) % 3]
}

fn one_sign([least, most]: Bounds) -> bool {
    (least >= 0.0 && most > 0.0) || (most <= 0.0 && least < 0.0)
}

fn with(at: &Vector3<f64>, fixed: &[(usize, f64)]) -> Vector3<f64> {
    let mut at = *at;
    fixed.iter().for_each(|(k, x)| at[*k] = *x);
    at
}

fn halve(low: &mut Vector3<f64>, high: &mut Vector3<f64>, axis: usize, upper: bool) {
    let middle = 0.5 * (low[axis] + high[axis]);
    if upper {
        low[axis] = middle;
    } else {
        high[axis] = middle;
    }
}

fn eighth(low: &Vector3<f64>, high: &Vector3<f64>, part: usize) -> [Vector3<f64>; 2] {
    let (mut low, mut high) = (*low, *high);
    (0..3).for_each(|axis| halve(&mut low, &mut high, axis, part >> axis & 1 == 1));
    [low, high]
}
