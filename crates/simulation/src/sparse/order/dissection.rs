//! An order of elimination by nested dissection: a few vertices that part the rest in two come last, and so in each part.

use super::super::graph::Graph;
use super::cut::{Cut, Cutter};
use super::levels::Levels;
use super::minimum_degree::minimum_degree_of;

/// Parts of no more unknowns are not cut: minimum degree orders them.
const LEAF_UNKNOWNS: usize = 100;

/// What is to be ordered next, the last first.
enum Task {
    Part(Vec<u32>),
    Between(Vec<u32>),
}

/// An order of elimination of the vertices of a graph, each of a weight, but of those in `root`, by nested dissection (George 1973).
///
/// With a place of each vertex, cuts go across the axes (Heath and Raghavan 1995), else by steps from vertices that are far apart.
pub(super) fn dissection(graph: &Graph, weights: &[usize], places: Option<&[[f64; 3]]>, root: &[bool]) -> Vec<u32> {
    let rest: Vec<u32> = (0..graph.size() as u32).filter(|i| !root[*i as usize]).collect();
    let mut order = Vec::with_capacity(rest.len());
    let (mut cutter, mut levels) = (Cutter::new(graph, weights), Levels::new(graph));
    let mut number = vec![u32::MAX; graph.size()];
    let mut tasks = vec![Task::Part(rest)];
    while let Some(task) = tasks.pop() {
        let part = match task {
            Task::Part(part) => part,
            Task::Between(between) => {
                order.extend(between);
                continue;
            }
        };
        // Not as a call within a call: a chain of cuts may be as long as it likes.
        for piece in levels.pieces(part) {
            match cut(&mut cutter, &mut levels, weights, places, &piece) {
                Some(Cut { sides, between, .. }) => {
                    // The last task is done first: what lies between comes after both sides.
                    tasks.push(Task::Between(between));
                    tasks.extend(sides.into_iter().map(Task::Part));
                }
                None => tasks.push(Task::Between(leaf(graph, weights, &piece, &mut number))),
            }
        }
    }
    order
}

/// A cut of a connected part that is large enough and has one.
fn cut(
    cutter: &mut Cutter<'_>,
    levels: &mut Levels<'_>,
    weights: &[usize],
    places: Option<&[[f64; 3]]>,
    piece: &[u32],
) -> Option<Cut> {
    let unknowns: usize = piece.iter().map(|i| weights[*i as usize]).sum();
    if unknowns <= LEAF_UNKNOWNS {
        return None;
    }
    let Some(places) = places else {
        return cutter.best(piece, &levels.directions(piece));
    };
    let along = |axis: usize| piece.iter().map(|i| places[*i as usize][axis]).collect();
    let axes: [Vec<f64>; 3] = [0, 1, 2].map(along);
    match cutter.best(piece, &axes) {
        Some(across) => {
            // Cells may lie across the axes.
            let straight = levels.straight(piece, axes[across.direction].clone());
            let other = cutter.best(piece, &[straight]);
            Some(other.filter(|other| other.cost < across.cost).unwrap_or(across))
        }
        // Nodes may lie in one place, or so that no plane parts them.
        None => cutter.best(piece, &levels.directions(piece)),
    }
}

/// A part that is not cut, by minimum degree among what lies around it.
fn leaf(graph: &Graph, weights: &[usize], part: &[u32], number: &mut [u32]) -> Vec<u32> {
    let (around, vertices) = graph.around(part, number);
    let own: Vec<usize> = vertices.iter().map(|i| weights[*i as usize]).collect();
    // What lies around is eliminated later but fills too: degrees without it would be too low.
    let order = minimum_degree_of(&around, &own, part.len());
    order.iter().map(|k| vertices[*k as usize]).collect()
}
