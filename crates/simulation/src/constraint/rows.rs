//! How a point of a boundary depends on the unknowns.

use std::ops::{Deref, DerefMut};

use nalgebra::Vector2;

use crate::bodies::Bodies;
use crate::q9::shape::line_slope;
use crate::solid::Cursor;
use crate::sparse::Triplets;

/// Derivatives of a point by one unknown, and of its slope by the parameter of its arc.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Row {
    pub(super) unknown: usize,
    /// `dM / da`.
    pub(super) by: Vector2<f64>,
    /// `dM_u / da`.
    pub(super) slope: Vector2<f64>,
}

/// Two points on two meshes: three nodes each, of two unknowns.
const USUAL_ROWS: usize = 12;

/// A list of rows that asks for no memory while it is as short as meshes make it.
#[derive(Debug, Clone, Default)]
pub(super) struct List {
    few: [Row; USUAL_ROWS],
    count: usize,
    /// All of them, once they are more.
    many: Vec<Row>,
}

impl List {
    #[inline]
    fn push(&mut self, row: Row) {
        if self.count < USUAL_ROWS {
            self.few[self.count] = row;
            self.count += 1;
            return;
        }
        // All move over together, so that `deref` has one slice to lend.
        if self.many.is_empty() {
            self.many.extend_from_slice(&self.few);
        }
        self.many.push(row);
    }
}

impl Deref for List {
    type Target = [Row];

    #[inline]
    fn deref(&self) -> &[Row] {
        if self.many.is_empty() {
            &self.few[..self.count]
        } else {
            &self.many
        }
    }
}

impl DerefMut for List {
    #[inline]
    fn deref_mut(&mut self) -> &mut [Row] {
        if self.many.is_empty() {
            &mut self.few[..self.count]
        } else {
            &mut self.many
        }
    }
}

/// The rows of a list, one after the other.
pub(super) struct Each {
    list: List,
    next: usize,
}

impl Iterator for Each {
    type Item = Row;

    #[inline]
    fn next(&mut self) -> Option<Row> {
        let row = self.list.get(self.next).copied();
        self.next += 1;
        row
    }
}

impl IntoIterator for List {
    type Item = Row;
    type IntoIter = Each;

    #[inline]
    fn into_iter(self) -> Each {
        Each { list: self, next: 0 }
    }
}

/// Rows of one point or of the difference of two, each unknown once.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows(pub(super) List);

impl Rows {
    /// Adds `sign` times a cursor's rows.
    pub(super) fn add(&mut self, bodies: &Bodies, body: usize, cursor: &Cursor, a: &[f64], sign: f64) {
        let (solid, offset) = (bodies.solid(body), bodies.offset(body));
        let (weights, slopes) = (cursor.weights(), line_slope(cursor.u));
        let before = self.0.len();
        for (k, node) in solid.boundary().arcs[cursor.arc].into_iter().enumerate() {
            let (weight, slope) = (sign * weights[k], sign * slopes[k]);
            if let Some(own) = solid.own(node) {
                // The nodes of an arc are three: only the other point can have moved one of them before.
                for (parameter, axis) in [(own, Vector2::x()), (own + 1, Vector2::y())] {
                    self.put(row(offset + parameter, axis, weight, slope), before);
                }
                continue;
            }
            solid.rows(bodies.part(body, a), node, &mut |parameter, by| {
                // A parameter of a rigid solid or of a block moves all three nodes: its row may be one of this arc's.
                let all = self.0.len();
                self.put(row(offset + parameter, by, weight, slope), all);
            });
        }
    }

    /// Adds to the row of its unknown among the first ones, or a row of its own.
    #[inline]
    fn put(&mut self, row: Row, first: usize) {
        match self.0[..first].iter_mut().find(|r| r.unknown == row.unknown) {
            Some(old) => {
                old.by += row.by;
                old.slope += row.slope;
            }
            None => self.0.push(row),
        }
    }

    /// Adds `form(p, q)` at every pair of unknowns.
    pub(super) fn add_form(&self, sink: &mut Triplets, form: impl Fn(&Row, &Row) -> f64) {
        self.add_form_of(sink, |row| *row, form);
    }

    /// The same of what `of` makes of each row.
    pub(super) fn add_form_of<K: Copy + Default>(
        &self,
        sink: &mut Triplets,
        of: impl Fn(&Row) -> K,
        form: impl Fn(&K, &K) -> f64,
    ) {
        let rows: &[Row] = &self.0;
        // More than the arrays below hold, as of a solid in a block of 18 parameters.
        if rows.len() > USUAL_ROWS {
            for (i, p) in rows.iter().enumerate() {
                let by = of(p);
                let each = rows[..=i].iter();
                each.for_each(|q| sink.add(p.unknown, q.unknown, form(&by, &of(q))));
            }
            return;
        }
        // As one dense part: samples of one arc follow one another, and have their unknowns in common.
        let (mut keys, mut values, mut count) =
            ([K::default(); USUAL_ROWS], [0.0; USUAL_ROWS * (USUAL_ROWS + 1) / 2], 0);
        for (i, row) in rows.iter().enumerate() {
            keys[i] = of(row);
            for other in &keys[..=i] {
                values[count] = form(&keys[i], other);
                count += 1;
            }
        }
        sink.add_block(rows.iter().map(|r| r.unknown), &values[..count]);
    }
}

#[inline]
fn row(unknown: usize, by: Vector2<f64>, weight: f64, slope: f64) -> Row {
    Row {
        unknown,
        by: by * weight,
        slope: by * slope,
    }
}

/// Adds `force . d2 M` of a cursor.
pub(super) fn bend(bodies: &Bodies, body: usize, cursor: &Cursor, a: &[f64], force: Vector2<f64>, sink: &mut Triplets) {
    let (solid, offset) = (bodies.solid(body), bodies.offset(body));
    for (node, weight) in solid.boundary().arcs[cursor.arc].into_iter().zip(cursor.weights()) {
        solid.bend(bodies.part(body, a), node, force * weight, sink, offset);
    }
}
