//! What a picture shows of the inside of solids: a number at each point, with its words and its colours.

use nalgebra::Vector2;
use simulation::q9::FieldPoint;
use simulation::solid::Solid;

use super::colour::Ramp;
use super::view::View;
use super::{fill, view::short};
use crate::model::Model;
use crate::run::State;
use crate::scene::raw::{RawField, RawUnits};
use picture::Canvas;

/// Of the numbers found, this part lies within the colours: corners where stress is infinite do not take them all.
const WITHIN: f64 = 0.99;
/// Points of a side of an element at which the range of a field is looked for.
const SAMPLES: u32 = 4;

/// A word for files and pictures.
pub(crate) fn file_word(field: RawField) -> &'static str {
    match field {
        RawField::Shape => "shape",
        RawField::Gradient => "gradient",
        RawField::Energy => "energy",
        RawField::VonMises => "von-mises",
        RawField::Principal => "principal",
    }
}

/// The quantity and its unit.
pub(super) fn words(field: RawField, units: &RawUnits) -> String {
    let stress = &units.stress;
    match field {
        RawField::Shape => "shape".to_owned(),
        RawField::Gradient => "|displacement gradient|".to_owned(),
        RawField::Energy => format!("elastic energy density, {stress}"),
        RawField::VonMises => format!("von Mises stress, {stress}"),
        RawField::Principal => format!("principal stress of the larger size, {stress}"),
    }
}

/// The number that a field shows at a point; NaN where it has none.
pub(super) fn value(field: RawField, point: &FieldPoint) -> f64 {
    let of_state = |f: fn(&(f64, simulation::law::Stress)) -> f64| point.state.as_ref().map_or(f64::NAN, f);
    match field {
        RawField::Shape => 0.0,
        RawField::Gradient => point.gradient.norm(),
        RawField::Energy => of_state(|s| s.0),
        RawField::VonMises => of_state(|s| s.1.von_mises()),
        RawField::Principal => of_state(|s| {
            let [a, b] = s.1.principal();
            if a.abs() >= b.abs() { a } else { b }
        }),
    }
}

/// A range of a field over states, and its largest number with the place of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span {
    pub(crate) ramp: Ramp,
    pub(crate) largest: f64,
}

/// The colours of a field over some states; `None` where nothing has it.
pub(crate) fn span<'a>(model: &Model, states: impl Iterator<Item = &'a State>, field: RawField) -> Option<Span> {
    let mut sizes = Vec::new();
    let mut largest = 0.0_f64;
    if field == RawField::Shape {
        return None;
    }
    for state in states {
        for body in 0..model.solids.len() {
            let (solid, part) = (
                model.system.bodies.solid(body),
                model.system.bodies.part(body, &state.a),
            );
            for patch in 0..solid.patches() {
                for at in grid(SAMPLES) {
                    let number = solid.field(part, patch, at).map_or(f64::NAN, |p| value(field, &p));
                    if number.is_finite() {
                        sizes.push(number.abs());
                        largest = if number.abs() > largest.abs() { number } else { largest };
                    }
                }
            }
        }
    }
    sizes.sort_by(f64::total_cmp);
    let at = ((sizes.len() as f64 * WITHIN) as usize).min(sizes.len().checked_sub(1)?);
    // Rounding of an undeformed solid is no field.
    let high = if sizes[at] > 1e-12 { sizes[at] } else { 0.0 };
    let ramp = match field {
        RawField::Principal => Ramp::about_zero(high),
        _ => Ramp::from_zero(high),
    };
    Some(Span { ramp, largest })
}

/// Local points of a grid of `n` x `n` intervals.
fn grid(n: u32) -> impl Iterator<Item = [f64; 2]> {
    let at = move |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
    (0..=n).flat_map(move |j| (0..=n).map(move |i| [at(i), at(j)]))
}

/// Fills the solids of a state with a field.
pub(super) fn fill(canvas: &mut Canvas, view: &View, model: &Model, state: &State, field: RawField, ramp: &Ramp) {
    for body in 0..model.solids.len() {
        let solid = model.system.bodies.solid(body);
        let part = model.system.bodies.part(body, &state.a);
        // As many pieces in all elements of a solid: where sides are cut alike, no gap opens between neighbours.
        let pieces = (0..solid.patches()).map(|patch| pieces(view, solid, part, patch));
        let pieces = pieces.max().unwrap_or_default();
        for patch in 0..solid.patches() {
            element(
                canvas,
                &Drawn {
                    view,
                    solid,
                    part,
                    field,
                    ramp,
                },
                patch,
                pieces,
            );
        }
    }
}

/// A solid that is being drawn.
struct Drawn<'a> {
    view: &'a View,
    solid: &'a dyn Solid,
    part: &'a [f64],
    field: RawField,
    ramp: &'a Ramp,
}

/// Pieces of about six pixels along a side of an element: colours between them run linearly.
fn pieces(view: &View, solid: &dyn Solid, part: &[f64], patch: usize) -> u32 {
    let place = |at: [f64; 2]| solid.field(part, patch, at).map_or(Vector2::zeros(), |p| p.position);
    let size = (place([1.0, 1.0]) - place([-1.0, -1.0])).norm() * view.scale;
    (size / 6.0).clamp(2.0, 16.0) as u32
}

fn element(canvas: &mut Canvas, of: &Drawn<'_>, patch: usize, n: u32) {
    let corners: Vec<fill::Corner> = grid(n)
        .map(|at| match of.solid.field(of.part, patch, at) {
            Some(p) => (of.view.pixel(p.position), value(of.field, &p)),
            None => (of.view.pixel(Vector2::zeros()), f64::NAN),
        })
        .collect();
    let across = n as usize + 1;
    for j in 0..n as usize {
        for i in 0..n as usize {
            let at = |di: usize, dj: usize| corners[(j + dj) * across + i + di];
            fill::triangle(canvas, &of.view.frame, of.ramp, [at(0, 0), at(1, 0), at(1, 1)]);
            fill::triangle(canvas, &of.view.frame, of.ramp, [at(0, 0), at(1, 1), at(0, 1)]);
        }
    }
}

/// A sentence about the largest number, where colours end below it.
pub(super) fn beyond(span: &Span) -> Option<String> {
    let over = span.largest.abs() > 1.001 * span.ramp.high;
    over.then(|| format!("largest {}", short(span.largest)))
}
