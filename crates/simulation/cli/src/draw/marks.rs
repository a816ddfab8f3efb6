//! Marks on a picture: outlines, arrows, crosses, cursors.

use nalgebra::Vector2;
use picture::{Canvas, Line, Rgb};
use simulation::solid::{Cursor, Solid};

use super::ink;
use super::view::View;
use crate::model::Model;
use crate::run::State;
use crate::scene::raw::RawField;

/// Pieces in which an arc is drawn.
const PIECES: u32 = 16;
/// The longest arrow, and the longest half of a cross, pixels.
const ARROW: f64 = 70.0;
const CROSS: f64 = 11.0;

/// Round the lines of crosses, so that they are seen on dark colours.
const RIM: Rgb = Rgb(255, 255, 255);
const FIRST: Rgb = Rgb(200, 30, 30);
const SECOND: Rgb = Rgb(30, 60, 200);
const THIRD: Rgb = Rgb(0, 130, 70);

/// The contours of a solid as pixels, arc after arc; a new contour where an arc does not begin at the last one's end.
pub(super) fn contours(view: &View, solid: &dyn Solid, part: &[f64]) -> Vec<Vec<[f64; 2]>> {
    let boundary = solid.boundary();
    let mut left = vec![true; boundary.arcs.len()];
    let mut contours = Vec::new();
    for first in 0..boundary.arcs.len() {
        let mut contour = Vec::new();
        let mut arc = first;
        while std::mem::take(&mut left[arc]) {
            let points = boundary.arcs[arc].map(|n| solid.point(part, n));
            contour
                .extend((0..PIECES).map(|k| view.pixel(on_arc(&points, f64::from(k) * 2.0 / f64::from(PIECES) - 1.0))));
            arc = boundary.next[arc];
        }
        if !contour.is_empty() {
            contours.push(contour);
        }
    }
    contours
}

fn on_arc(points: &[Vector2<f64>; 3], u: f64) -> Vector2<f64> {
    let weights = Cursor { arc: 0, u }.weights();
    points.iter().zip(weights).map(|(p, w)| p * w).sum()
}

/// Closed lines along contours.
pub(super) fn outline(canvas: &mut Canvas, contours: &[Vec<[f64; 2]>], line: Line) {
    for contour in contours {
        let closed: Vec<[f64; 2]> = contour.iter().chain(contour.first()).copied().collect();
        canvas.polyline(&closed, line);
    }
}

/// The sides of all elements, thin.
pub(super) fn mesh(canvas: &mut Canvas, view: &View, solid: &dyn Solid, part: &[f64], line: Line) {
    for patch in 0..solid.patches() {
        let side = |at: &dyn Fn(f64) -> [f64; 2]| -> Vec<[f64; 2]> {
            let each = (0..=8).map(|k| at(0.25 * f64::from(k) - 1.0));
            each.filter_map(|at| Some(view.pixel(solid.field(part, patch, at)?.position)))
                .collect()
        };
        for end in [-1.0, 1.0] {
            canvas.polyline(&side(&|t| [t, end]), line);
            canvas.polyline(&side(&|t| [end, t]), line);
        }
    }
}

/// An arrow between two pixels.
pub(super) fn arrow(canvas: &mut Canvas, from: [f64; 2], to: [f64; 2], colour: Rgb, width: f32) {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let length = dx.hypot(dy);
    if length.is_nan() || length < 1.0 {
        return;
    }
    let (x, y) = (dx / length, dy / length);
    let head = (3.5 * f64::from(width)).min(0.6 * length);
    let neck = [to[0] - x * head, to[1] - y * head];
    canvas.line(from, neck, Line::solid(ink(colour), width));
    let half = 0.45 * head;
    let barbs = vec![
        to,
        [neck[0] - y * half, neck[1] + x * half],
        [neck[0] + y * half, neck[1] - x * half],
    ];
    canvas.area(&[barbs], ink(colour), 255);
}

/// Arrows of the forces of contacts and links; the largest force, which is drawn the longest.
pub(super) fn forces(canvas: &mut Canvas, view: &View, state: &State, colour: Rgb, small: bool) -> f64 {
    let largest = state.contacts.iter().map(|c| c.force.norm()).fold(0.0, f64::max);
    let length = if small { 0.5 * ARROW } else { ARROW };
    for contact in &state.contacts {
        let size = length * contact.force.norm() / largest;
        let way = contact.force.try_normalize(0.0).unwrap_or_default();
        let at = view.pixel(contact.point);
        // The arrow ends where the force acts: it stands on the side that pushes.
        let tail = [at[0] - way.x * size, at[1] + way.y * size];
        arrow(canvas, tail, at, colour, if small { 1.3 } else { 2.0 });
    }
    largest
}

/// Crosses at points of the inside: the columns of `F`, or the principal stresses.
pub(super) fn crosses(canvas: &mut Canvas, view: &View, model: &Model, state: &State, field: RawField, high: f64) {
    for body in 0..model.solids.len() {
        let (solid, part) = (
            model.system.bodies.solid(body),
            model.system.bodies.part(body, &state.a),
        );
        for patch in 0..solid.patches() {
            for at in [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]] {
                let Some(point) = solid.field(part, patch, at) else {
                    continue;
                };
                let centre = view.pixel(point.position);
                match field {
                    RawField::Gradient => columns(canvas, centre, &point.gradient),
                    RawField::Principal => principal(canvas, centre, point.state.map(|s| s.1), high),
                    _ => {}
                }
            }
        }
    }
}

fn columns(canvas: &mut Canvas, centre: [f64; 2], gradient: &nalgebra::Matrix2<f64>) {
    for (column, colour) in [(0, FIRST), (1, SECOND)] {
        let image = gradient.column(column) + if column == 0 { Vector2::x() } else { Vector2::y() };
        let end = [centre[0] + CROSS * image.x, centre[1] - CROSS * image.y];
        canvas.line(centre, end, Line::solid(ink(RIM), 3.4));
        arrow(canvas, centre, end, colour, 1.3);
    }
}

fn principal(canvas: &mut Canvas, centre: [f64; 2], stress: Option<simulation::law::Stress>, high: f64) {
    let Some(stress) = stress else { return };
    let [greater, less] = stress.principal();
    let quarter = 0.5 * std::f64::consts::PI;
    for (size, angle) in [(greater, stress.direction()), (less, stress.direction() + quarter)] {
        let half = CROSS * (size.abs() / high).min(1.5);
        let (x, y) = (half * angle.cos(), -half * angle.sin());
        let colour = if size > 0.0 { FIRST } else { SECOND };
        let ends = [[centre[0] - x, centre[1] - y], [centre[0] + x, centre[1] + y]];
        canvas.line(ends[0], ends[1], Line::solid(ink(RIM), 3.0));
        canvas.line(ends[0], ends[1], Line::solid(ink(colour), 1.4));
    }
}

/// Cursors along the boundary of a solid, `every` apart: tangent, normal and second derivative by the reference length.
pub(super) fn cursors(canvas: &mut Canvas, view: &View, model: &Model, state: &State, solid: usize, every: f64) {
    let (body, part) = (
        model.system.bodies.solid(solid),
        model.system.bodies.part(solid, &state.a),
    );
    let boundary = body.boundary();
    let mut left: Vec<bool> = vec![true; boundary.arcs.len()];
    for first in 0..boundary.arcs.len() {
        let mut arc = first;
        let mut length = 0.0;
        let start = Cursor { arc: first, u: -1.0 };
        while std::mem::take(&mut left[arc]) {
            length += reference_length(&boundary.reference[arc]);
            arc = boundary.next[arc];
        }
        let count = (length / every).floor().min(2000.0) as u32;
        for k in 0..count {
            cursor(
                canvas,
                view,
                body,
                part,
                &start.moved(body, f64::from(k) * every),
                every,
            );
        }
    }
}

fn reference_length(arc: &[Vector2<f64>; 3]) -> f64 {
    let at = |k: u32| on_arc(arc, f64::from(k) / 8.0 - 1.0);
    (0..16).map(|k| (at(k + 1) - at(k)).norm()).sum()
}

fn cursor(canvas: &mut Canvas, view: &View, body: &dyn Solid, part: &[f64], cursor: &Cursor, every: f64) {
    let local = cursor.local(body, part);
    let at = view.pixel(local.position);
    let end = |v: Vector2<f64>| {
        let (x, y) = (v.x * view.scale, v.y * view.scale);
        let size = x.hypot(y);
        // A second derivative has no bound where a boundary bends sharply.
        let fit = if size > 1.5 * ARROW { 1.5 * ARROW / size } else { 1.0 };
        [at[0] + x * fit, at[1] - y * fit]
    };
    arrow(canvas, at, end(local.tangent * (0.9 * every)), FIRST, 1.5);
    arrow(canvas, at, end(local.normal() * (0.9 * every)), SECOND, 1.5);
    // A second derivative is the inverse of a length: one of a quarter of the solid is drawn as long as the tangent.
    let unit = 0.25 * body.boundary().extent();
    arrow(canvas, at, end(local.second * (0.9 * every * unit)), THIRD, 1.5);
    canvas.circle(at, 2.0, Line::solid(ink(Rgb(0, 0, 0)), 2.0));
}

/// The deepest points of solids in one another, and the nearest points of the boundaries they must come to.
pub(super) fn intruders(canvas: &mut Canvas, view: &View, model: &Model) {
    for pair in &model.separated {
        let [from, to] = pair.at.map(|p| view.pixel(p));
        canvas.line(from, to, Line::solid(ink(FIRST), 1.5));
        for at in [from, to] {
            canvas.circle(at, 2.5, Line::solid(ink(FIRST), 3.0));
        }
    }
}

/// The words that explain the marks of a picture.
pub(super) fn legend(field: RawField, cursors: bool) -> Option<(&'static str, Rgb)> {
    match field {
        _ if cursors => Some(("red: tangent, blue: normal, green: second derivative", Rgb(60, 60, 60))),
        RawField::Gradient => Some(("arrows: F x (red) and F y (blue)", Rgb(60, 60, 60))),
        RawField::Principal => Some(("bars: principal stresses, red pulled, blue pressed", Rgb(60, 60, 60))),
        _ => None,
    }
}
