//! An elimination in parts that need nothing from one another, and what comes after them.

use std::ops::Range;

use super::symbolic::Symbolic;

/// Runs of subtrees are so many times as many as threads, as they differ in work.
const RUNS_PER_THREAD: usize = 6;

/// Fronts that follow one another.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Part {
    /// Whole subtrees, for any thread.
    Run(Range<usize>),
    /// A front above them.
    Top(usize),
}

/// The first fronts in runs of whole subtrees with no more than their part of the work, and the fronts above them.
pub(super) fn parts(symbolic: &Symbolic, count: usize, threads: usize) -> Vec<Part> {
    // Of each front's subtree: its first front, and its work.
    let (mut subtrees, mut waiting): (Vec<(usize, f64)>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut whole = 0.0;
    for (k, front) in symbolic.fronts[..count].iter().enumerate() {
        let [w, h] = [front.width as f64, front.height as f64];
        // The work of a dense elimination up to a factor, as only its parts of the whole matter.
        let own = w * (w * w / 3.0 + w * h + h * h);
        whole += own;
        let mut subtree = (k, own);
        for child in waiting.drain(waiting.len() - front.children..) {
            let (first, work) = subtrees[child];
            subtree = (subtree.0.min(first), subtree.1 + work);
        }
        if front.height > 0 {
            waiting.push(k);
        }
        subtrees.push(subtree);
    }
    let most = whole / (RUNS_PER_THREAD * threads) as f64;
    let (mut parts, mut run) = (Vec::new(), (count..count, 0.0));
    let mut next = count;
    // Backwards, as a subtree ends with its root: the last front of what is left is the root of one.
    while next > 0 {
        let (first, work) = subtrees[next - 1];
        if work > most {
            // Too much for one run: this front waits above, and its subtrees are looked at one by one.
            parts.extend([Part::Run(run.0), Part::Top(next - 1)]);
            (run, next) = ((next - 1..next - 1, 0.0), next - 1);
            continue;
        }
        if run.1 + work > most {
            parts.push(Part::Run(run.0));
            run = (next..next, 0.0);
        }
        run = (first..run.0.end, run.1 + work);
        next = first;
    }
    parts.push(Part::Run(run.0));
    parts.retain(|part| !matches!(part, Part::Run(fronts) if fronts.is_empty()));
    parts.reverse();
    parts
}
