//! The fewest vertices that touch every edge of a graph of two sides.

use std::collections::VecDeque;

const NONE: u32 = u32::MAX;

/// Edges between two sides of numbered vertices: the right ends of those of each left vertex.
#[derive(Debug, Default)]
pub(crate) struct Sides {
    pub(crate) left: Vec<Vec<u32>>,
    pub(crate) right: usize,
}

/// A cover: the left and the right vertices in it.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Cover {
    pub(crate) left: Vec<bool>,
    pub(crate) right: Vec<bool>,
}

/// A smallest set of vertices that every edge has an end in (Koenig 1931): as many as a largest matching has edges. Where there
/// are several, the one with the most on the left.
pub(crate) fn smallest_cover(sides: &Sides) -> Cover {
    let mut matching = Matching {
        of_left: vec![NONE; sides.left.len()],
        of_right: vec![NONE; sides.right],
        from: vec![NONE; sides.right],
        touched: Vec::new(),
        queue: VecDeque::new(),
    };
    for (l, ends) in sides.left.iter().enumerate() {
        // Most find a free partner at once.
        if let Some(&r) = ends.iter().find(|r| matching.of_right[**r as usize] == NONE) {
            matching.of_left[l] = r;
            matching.of_right[r as usize] = l as u32;
        }
    }
    for l in 0..sides.left.len() {
        if matching.of_left[l] == NONE {
            matching.augment(sides, l as u32);
        }
    }
    matching.cover(sides)
}

struct Matching {
    of_left: Vec<u32>,
    of_right: Vec<u32>,
    /// The left vertex that each right one was reached from.
    from: Vec<u32>,
    touched: Vec<u32>,
    queue: VecDeque<u32>,
}

impl Matching {
    /// Looks for a path from an unmatched left vertex to an unmatched right one, every other edge matched, and swaps its edges.
    fn augment(&mut self, sides: &Sides, start: u32) {
        self.queue.clear();
        self.queue.push_back(start);
        let mut end = NONE;
        // Breadth first: the path found is a shortest one, so that few edges are swapped.
        'search: while let Some(l) = self.queue.pop_front() {
            for &r in &sides.left[l as usize] {
                if self.from[r as usize] != NONE {
                    continue;
                }
                self.from[r as usize] = l;
                self.touched.push(r);
                match self.of_right[r as usize] {
                    NONE => {
                        end = r;
                        break 'search;
                    }
                    next => self.queue.push_back(next),
                }
            }
        }
        // Back from its end: what each left vertex gives up, the one before it takes. The start has nothing to give.
        while end != NONE {
            let l = self.from[end as usize];
            self.of_right[end as usize] = l;
            end = std::mem::replace(&mut self.of_left[l as usize], end);
        }
        // Only what was reached is reset: a search costs what it meets, not the size of the graph.
        for r in self.touched.drain(..) {
            self.from[r as usize] = NONE;
        }
    }

    /// What unmatched left vertices reach by paths of which every other edge is matched: the right ones of it, and the left ones not of it.
    fn cover(mut self, sides: &Sides) -> Cover {
        let mut left = vec![true; sides.left.len()];
        let mut right = vec![false; sides.right];
        self.queue.clear();
        for (l, r) in self.of_left.iter().enumerate() {
            if *r == NONE {
                left[l] = false;
                self.queue.push_back(l as u32);
            }
        }
        while let Some(l) = self.queue.pop_front() {
            for &r in &sides.left[l as usize] {
                if std::mem::replace(&mut right[r as usize], true) {
                    continue;
                }
                // A right vertex without a partner would end a path that makes the matching larger.
                if let Some(inside) = left.get_mut(self.of_right[r as usize] as usize)
                    && *inside
                {
                    *inside = false;
                    self.queue.push_back(self.of_right[r as usize]);
                }
            }
        }
        // A left vertex without edges covers none.
        for (inside, ends) in left.iter_mut().zip(&sides.left) {
            *inside &= !ends.is_empty();
        }
        Cover { left, right }
    }
}
