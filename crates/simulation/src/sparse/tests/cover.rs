//! Smallest covers against all subsets.

use super::super::order::{Sides, smallest_cover};
use super::meshes::Numbers;

#[test]
fn covers_are_as_small_as_any() {
    let mut numbers = Numbers(5);
    for round in 0..400 {
        let (left, right) = (1 + round % 5, 1 + round / 5 % 5);
        let sides = Sides {
            left: (0..left)
                .map(|_| (0..right as u32).filter(|_| numbers.next() > 0.1).collect())
                .collect(),
            right,
        };
        let covers = |chosen: usize| {
            let edges = sides
                .left
                .iter()
                .enumerate()
                .flat_map(|(l, ends)| ends.iter().map(move |r| (l, *r as usize)));
            edges
                .into_iter()
                .all(|(l, r)| chosen >> l & 1 == 1 || chosen >> (left + r) & 1 == 1)
        };
        let least = (0..1 << (left + right))
            .filter(|c| covers(*c))
            .map(|c: usize| c.count_ones())
            .min()
            .unwrap();
        let found = smallest_cover(&sides);
        let all = found.left.iter().chain(&found.right);
        let chosen = all
            .enumerate()
            .map(|(k, taken)| usize::from(*taken) << k)
            .sum::<usize>();
        assert!(covers(chosen));
        assert_eq!(chosen.count_ones(), least);
    }
}
