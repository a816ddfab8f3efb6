//! Distances to the surface itself.

use std::cell::RefCell;

use nalgebra::Vector3;

use super::Distances;
use crate::Field;
use crate::tree::{Foot, Tree};

/// How far a point may go before the triangles near it are gathered anew, mm: more than the field's error, by which a fit that begins
/// where one on the field ended moves points.
const ROOM_MM: f64 = 0.2;
/// By how much the field is too short for the most part, mm; where it is by more, each look goes through the tree.
const FIELD_MM: f64 = 0.2;
/// The most triangles that are kept for a point; where more are near, each look goes through the tree.
const MOST_NEAR: usize = 32;

/// The surface itself, with what was found for each point the last time.
pub(crate) struct Exact<'a> {
    tree: &'a Tree,
    field: &'a Field,
    points: RefCell<Vec<Looked>>,
}

/// Where a point was looked at, and what was found.
#[derive(Clone)]
struct Looked {
    at: Vector3<f64>,
    foot: Option<Foot>,
    mm: f64,
    normal: Vector3<f64>,
    /// Where the triangles near it were gathered, and those.
    about: Vector3<f64>,
    near: Vec<u32>,
}

impl<'a> Exact<'a> {
    pub(crate) fn new(tree: &'a Tree, field: &'a Field, points: usize) -> Self {
        let nowhere = Vector3::repeat(f64::NAN);
        let looked = Looked {
            at: nowhere,
            foot: None,
            mm: f64::NAN,
            normal: Vector3::zeros(),
            about: nowhere,
            near: Vec::new(),
        };
        Self {
            tree,
            field,
            points: RefCell::new(vec![looked; points]),
        }
    }

    /// The normal of the smooth surface that the facets stand for, where a point was looked at last, and by how much it bulges there, mm.
    pub(crate) fn smooth(&self, point: usize) -> Option<(Vector3<f64>, f64)> {
        let foot = self.points.borrow()[point].foot?;
        Some(self.tree.smooth(&foot))
    }

    /// The nearest place to `p`; `about_mm` is its distance by the field.
    fn find(&self, looked: &mut Looked, p: &Vector3<f64>, about_mm: f64) -> Option<Foot> {
        let tree = self.tree;
        looked.about = *p;
        let reach = about_mm + FIELD_MM + 2.0 * ROOM_MM;
        if tree.gather(p, reach, MOST_NEAR, &mut looked.near).is_some()
            && let Some(foot) = tree.foot_among(p, &looked.near)
            // Rounding of the two roots: far less than a micrometre.
            && foot.distance2.sqrt() + 2.0 * ROOM_MM + 1e-6 < reach
        {
            return Some(foot);
        }
        // Many small triangles, or a field that is further off than that: each look for itself.
        looked.near.clear();
        tree.foot(p, f64::INFINITY, looked.foot.map(|foot| foot.triangle))
    }
}

impl Distances for Exact<'_> {
    fn look(&self, point: usize, p: &Vector3<f64>, reach_mm: f64) -> (f64, Vector3<f64>, bool) {
        let looked = &mut self.points.borrow_mut()[point];
        // A fit ends where its deviations are asked for next.
        if looked.at != *p {
            // Of a point within r of another one the nearest place is within d + r, and within d + 2 r of the other one.
            let is_near = !looked.near.is_empty() && (looked.about - p).norm() < ROOM_MM;
            let foot = if is_near {
                self.tree.foot_among(p, &looked.near)
            } else {
                // A nearest place that is far away is dear to find, and a point that has no say need not have it. No distance differs
                // from another one by more than the way between the two, and the mean way to the nodes of a cell, weighted as they
                // are, is below 0.87 of its side; nodes are too long by less than a tenth.
                let (d, n) = self.field.look(p);
                if d.abs() > reach_mm + self.field.spacing().spacing_mm {
                    return (d, n, self.field.is_beyond(p));
                }
                self.find(looked, p, d.abs())
            };
            let Some(foot) = foot else {
                return (f64::NAN, Vector3::zeros(), true);
            };
            (looked.mm, looked.normal) = foot.signed(p);
            (looked.at, looked.foot) = (*p, Some(foot));
        }
        (looked.mm, looked.normal, looked.foot.is_some_and(|foot| foot.is_open))
    }
}
