//! How a point of a boundary depends on the unknowns.

use nalgebra::Vector2;

use crate::q9::shape::line_slope;
use crate::solid::Cursor;
use crate::sparse::Triplets;
use crate::system::Bodies;

/// Derivatives of a point by one unknown, and of its slope by the parameter of its arc.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub(super) unknown: usize,
    /// `dM / da`.
    pub(super) by: Vector2<f64>,
    /// `dM_u / da`.
    pub(super) slope: Vector2<f64>,
}

/// Rows of one point or of the difference of two, each unknown once.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows(pub(super) Vec<Row>);

impl Rows {
    /// Adds `sign` times a cursor's rows.
    pub(super) fn add(&mut self, bodies: &Bodies, body: usize, cursor: &Cursor, a: &[f64], sign: f64) {
        let (solid, offset) = (bodies.solid(body), bodies.offset(body));
        let (weights, slopes) = (cursor.weights(), line_slope(cursor.u));
        // Two points on two meshes: three nodes each.
        if self.0.capacity() == 0 {
            self.0.reserve(12);
        }
        for (k, node) in solid.boundary().arcs[cursor.arc].into_iter().enumerate() {
            solid.rows(bodies.part(body, a), node, &mut |parameter, by| {
                self.put(Row {
                    unknown: offset + parameter,
                    by: by * (sign * weights[k]),
                    slope: by * (sign * slopes[k]),
                });
            });
        }
    }

    fn put(&mut self, row: Row) {
        match self.0.iter_mut().find(|r| r.unknown == row.unknown) {
            Some(old) => {
                old.by += row.by;
                old.slope += row.slope;
            }
            None => self.0.push(row),
        }
    }

    /// Adds `form(p, q)` at every pair of unknowns.
    pub(super) fn add_form(&self, sink: &mut Triplets, form: impl Fn(&Row, &Row) -> f64) {
        for (i, p) in self.0.iter().enumerate() {
            for q in &self.0[..=i] {
                sink.add(p.unknown, q.unknown, form(p, q));
            }
        }
    }
}

/// Adds `force . d2 M` of a cursor.
pub(super) fn bend(bodies: &Bodies, body: usize, cursor: &Cursor, a: &[f64], force: Vector2<f64>, sink: &mut Triplets) {
    let (solid, offset) = (bodies.solid(body), bodies.offset(body));
    for (node, weight) in solid.boundary().arcs[cursor.arc].into_iter().zip(cursor.weights()) {
        solid.bend(bodies.part(body, a), node, force * weight, sink, offset);
    }
}
