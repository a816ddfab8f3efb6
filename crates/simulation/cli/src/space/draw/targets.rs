//! Targets on a cut: a cross where each is now, its name, and the ellipse of the model's error.

use geometry::SlicePlane;
use nalgebra::{Matrix2, SymmetricEigen, Vector2, Vector3};
use picture::{Anchor, Canvas, Line};
use simulation::space::error::Spread;

use super::super::errors::Said;
use super::super::report::Whole;
use super::super::run::State;
use super::{frame, skin};

/// Nearer to a cut than this a target is in it, mm.
const IN: f64 = 2.0;
/// Farther from it than this none is drawn, mm.
const FARTHEST: f64 = 15.0;
/// Half of a cross, pixels.
const ARM: f64 = 6.0;
/// Corners of an ellipse.
const CORNERS: usize = 48;

/// A target in a state.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mark<'a> {
    name: &'a str,
    /// In the patient, now.
    pub(super) at: Vector3<f64>,
    spread: Option<Spread>,
}

/// All targets in a state whose forces balance; none in another.
pub(super) fn marks<'a>(whole: &Whole<'a>, state: &State) -> Vec<Mark<'a>> {
    let (model, labels) = (whole.model, whole.labels);
    let spread = |k: usize| match whole.errors {
        Said::Found(errors) if errors.of == state.label => errors.model.targets.get(k).copied().flatten(),
        _ => None,
    };
    let each = model.targets.iter().enumerate().filter(|_| state.found.is_some());
    let mark = |(k, target): (usize, &'a organs::Target)| Mark {
        name: &target.name,
        at: target.at + labels.turned(&target.moved(&model.system.bodies, &state.a)),
        spread: spread(k),
    };
    each.map(mark).collect()
}

/// Draws the targets that a cut at a corner of a canvas shows: bright ones in it, others quiet with their distance.
pub(super) fn draw(canvas: &mut Canvas, plane: &SlicePlane, corner: [f64; 2], marks: &[Mark<'_>]) {
    let [width, height] = plane.size().map(f64::from);
    for mark in marks {
        let on = plane.project(skin::point(&mark.at));
        let inside = (0.0..width).contains(&on.x) && (0.0..height).contains(&on.y);
        if !inside || on.depth_mm.abs() > FARTHEST {
            continue;
        }
        let at = [corner[0] + on.x, corner[1] + on.y];
        let (colour, name) = if on.depth_mm.abs() <= IN {
            (frame::WORDS, mark.name.to_owned())
        } else {
            let side = if on.depth_mm > 0.0 { "behind" } else { "before" };
            (
                frame::QUIET,
                format!("{}, {:.0} mm {side}", mark.name, on.depth_mm.abs()),
            )
        };
        let line = Line::solid(colour, 1.6).with_rim(1.0);
        canvas.line([at[0] - ARM, at[1]], [at[0] + ARM, at[1]], line);
        canvas.line([at[0], at[1] - ARM], [at[0], at[1] + ARM], line);
        if let Some(spread) = &mark.spread {
            canvas.polyline(&ellipse(plane, spread, at), Line::solid(colour, 1.2).with_rim(0.6));
        }
        // A name does not go on beyond its cut.
        let (by, anchor) = if on.x < 0.6 * width {
            (10.0, Anchor::Left)
        } else {
            (-10.0, Anchor::Right)
        };
        canvas.text([at[0] + by, at[1] - 10.0], &name, 12.0, colour, anchor);
    }
}

/// The shadow of the ellipsoid of 95 % on a plane, pixels about a place.
fn ellipse(plane: &SlicePlane, spread: &Spread, at: [f64; 2]) -> Vec<[f64; 2]> {
    let axes = [plane.right(), plane.down()].map(|d| Vector3::from(d.vector().mm()));
    let covariance = Matrix2::from_fn(|r, c| axes[r].dot(&(spread.covariance * axes[c])));
    let eigen = SymmetricEigen::new(covariance);
    let half = [0, 1].map(|k| spread.half_axes_95() * eigen.eigenvalues[k].max(0.0).sqrt() / plane.pixel_mm());
    let corner = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / CORNERS as f64;
        let by = eigen.eigenvectors * Vector2::new(half[0] * angle.cos(), half[1] * angle.sin());
        [at[0] + by.x, at[1] + by.y]
    };
    (0..=CORNERS).map(corner).collect()
}
