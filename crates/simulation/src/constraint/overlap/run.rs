//! What is left of a boundary between its contacts with another: runs that lie wholly inside of it or wholly outside.

use std::collections::BTreeMap;

use crate::solid::Boundary;

/// Parts of each arc, parameters from 0 to 1.
pub(super) type Parts = BTreeMap<usize, Vec<[f64; 2]>>;

/// Less than this part of an arc between two contacts is rounding of the parameter.
const LEAST_ARC_PART: f64 = 1e-14;

/// A piece of boundary without contact: parts of arcs, one after the other.
pub(super) type Run = Vec<(usize, [f64; 2])>;

/// The boundary's contours, cut at the contacts.
#[derive(Debug, Default)]
pub(super) struct Runs {
    pub(super) free: Vec<Run>,
    /// Contours that are contact all round, by their arcs.
    pub(super) covered: Vec<Vec<usize>>,
}

impl Runs {
    pub(super) fn of(boundary: &Boundary, contacts: Option<&Parts>) -> Self {
        let mut runs = Self::default();
        for contour in contours(boundary) {
            let before = runs.free.len();
            for &arc in &contour {
                let parts = contacts
                    .and_then(|parts| parts.get(&arc))
                    .map_or(&[][..], Vec::as_slice);
                for gap in gaps(parts) {
                    // Exact: a gap begins at 0 only where no contact does.
                    let goes_on = gap[0] == 0.0 && runs.free.len() > before;
                    match runs.free.last_mut().filter(|run| goes_on && leads(boundary, run, arc)) {
                        Some(run) => run.push((arc, gap)),
                        None => runs.free.push(vec![(arc, gap)]),
                    }
                }
            }
            runs.close(boundary, before, contour);
        }
        runs
    }

    /// Joins the last run of a contour to its first, where the contour is closed and there is no contact between.
    fn close(&mut self, boundary: &Boundary, before: usize, contour: Vec<usize>) {
        let own = &self.free[before..];
        if own.is_empty() {
            self.covered.push(contour);
            return;
        }
        let [first, last] = [&own[0], &own[own.len() - 1]];
        let (arc, [from, _]) = first[0];
        // One run alone has no other end to be joined to.
        if own.len() > 1 && from == 0.0 && leads(boundary, last, arc) {
            let last = self.free.pop().unwrap_or_default();
            self.free[before].extend(last);
        }
    }
}

/// True where a run goes on over the end of its last arc to this one.
fn leads(boundary: &Boundary, run: &Run, arc: usize) -> bool {
    run.last()
        .is_some_and(|(last, [_, to])| *to == 1.0 && boundary.next[*last] == arc)
}

/// Arcs in the order in which they follow one another, contour by contour.
fn contours(boundary: &Boundary) -> Vec<Vec<usize>> {
    let mut seen = vec![false; boundary.arcs.len()];
    let mut found = Vec::new();
    for start in 0..seen.len() {
        let (mut contour, mut arc) = (Vec::new(), start);
        while !seen[arc] {
            seen[arc] = true;
            contour.push(arc);
            arc = boundary.next[arc];
        }
        if !contour.is_empty() {
            found.push(contour);
        }
    }
    found
}

/// What some parts leave of an arc.
fn gaps(parts: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut parts = parts.to_vec();
    parts.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut gaps, mut from) = (Vec::new(), 0.0);
    for [start, end] in parts {
        if start - from > LEAST_ARC_PART {
            gaps.push([from, start]);
        }
        // Contacts may overlap or lie within one another.
        from = end.max(from);
    }
    if 1.0 - from > LEAST_ARC_PART {
        gaps.push([from, 1.0]);
    }
    gaps
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    #[test]
    fn contacts_cut_contours_into_runs() {
        // Two triangles.
        let arcs = vec![[0, 6, 1], [1, 7, 2], [2, 8, 0], [3, 9, 4], [4, 10, 5], [5, 11, 3]];
        let boundary = Boundary::new(arcs, |n| Vector2::new(n as f64, (n * n) as f64));
        let count = |contacts: &[(usize, [f64; 2])]| {
            let mut parts = Parts::new();
            contacts
                .iter()
                .for_each(|(arc, part)| parts.entry(*arc).or_default().push(*part));
            let runs = Runs::of(&boundary, Some(&parts));
            let mut lengths: Vec<usize> = runs.free.iter().map(Vec::len).collect();
            lengths.sort_unstable();
            (lengths, runs.covered.len())
        };
        assert_eq!(count(&[]), (vec![3, 3], 0));
        assert_eq!(count(&[(1, [0.2, 0.3])]), (vec![3, 4], 0));
        assert_eq!(
            count(&[(1, [0.2, 0.3]), (1, [0.25, 0.6]), (2, [0.5, 0.6])]),
            (vec![2, 3, 3], 0)
        );
        // At a node, on one side of it or both.
        assert_eq!(count(&[(0, [0.9, 1.0])]), (vec![3, 3], 0));
        assert_eq!(count(&[(0, [0.0, 0.1]), (2, [0.9, 1.0])]), (vec![3, 3], 0));
        assert_eq!(
            count(&[(0, [0.0, 1.0]), (1, [0.0, 1.0]), (2, [0.0, 1.0])]),
            (vec![3], 1)
        );
        assert_eq!(count(&[(1, [0.0, 1.0])]), (vec![2, 3], 0));
        let none = Runs::of(&boundary, None);
        assert_eq!((none.free.len(), none.covered.len()), (2, 0));
    }
}
