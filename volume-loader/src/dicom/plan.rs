//! Which slices of the files make each slice of the grid.

/// Neighbours farther apart than this many median steps have a hole between them.
const HOLE_STEPS: f64 = 2.2;
/// A place of the grid this close to a slice, in steps, is that slice.
const SAME_STEPS: f64 = 1e-3;

/// Where one slice of the grid comes from. Slices are counted in order along the stack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Take {
    /// This slice as it is.
    Whole(usize),
    /// This slice and the next, which has this weight.
    Between(usize, f64),
    /// Nothing was measured here.
    Hole,
}

/// How many slices an even grid has from the first place to the last, which may be more than memory holds.
pub(crate) fn even_count(along_mm: &[f64], step_mm: f64) -> i64 {
    let length = along_mm.last().copied().unwrap_or(0.0);
    // Saturates; a grid of that many is refused.
    ((length / step_mm + SAME_STEPS).floor() as i64).saturating_add(1)
}

/// An even grid of `count` slices from the first place on, by linear interpolation along the line of positions. Places
/// ascend; a hole stays one.
pub(crate) fn even_grid(along_mm: &[f64], step_mm: f64, count: u32) -> Vec<Take> {
    let mut below = 0;
    let mut take = |k: u32| {
        let at = f64::from(k) * step_mm;
        while along_mm
            .get(below + 1)
            .is_some_and(|&next| next <= at + SAME_STEPS * step_mm)
        {
            below += 1;
        }
        let low = along_mm.get(below).copied().unwrap_or(0.0);
        let Some(&high) = along_mm.get(below + 1) else {
            return Take::Whole(below);
        };
        if (at - low).abs() <= SAME_STEPS * step_mm {
            return Take::Whole(below);
        }
        match high - low > HOLE_STEPS * step_mm {
            true => Take::Hole,
            false => Take::Between(below, (at - low) / (high - low)),
        }
    };
    (0..count).map(&mut take).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_hole_stays_a_hole_and_a_missing_slice_is_interpolated() {
        let along = [0.0, 2.0, 6.0, 8.0, 18.0, 20.0];
        assert_eq!(even_count(&along, 2.0), 11);
        let plan = even_grid(&along, 2.0, 11);
        let mut want = vec![
            Take::Whole(0),
            Take::Whole(1),
            Take::Between(1, 0.5),
            Take::Whole(2),
            Take::Whole(3),
        ];
        want.extend([Take::Hole; 4]);
        want.extend([Take::Whole(4), Take::Whole(5)]);
        assert_eq!(plan, want);
    }

    proptest! {
        #[test]
        fn every_place_lies_between_the_slices_it_is_made_of(steps in prop::collection::vec(0.2..9.0_f64, 2..20)) {
            let mut along = vec![0.0];
            for step in steps {
                along.push(along[along.len() - 1] + step);
            }
            let count = even_count(&along, 1.0);
            prop_assert!((along[along.len() - 1] - (count - 1) as f64) < 1.0);
            for (k, take) in even_grid(&along, 1.0, count as u32).into_iter().enumerate() {
                match take {
                    Take::Whole(i) => prop_assert!((along[i] - k as f64).abs() <= SAME_STEPS),
                    Take::Between(i, weight) => {
                        let at = along[i] + weight * (along[i + 1] - along[i]);
                        prop_assert!((at - k as f64).abs() < 1e-9 && along[i + 1] - along[i] <= HOLE_STEPS);
                    }
                    Take::Hole => prop_assert!(along.iter().all(|place| (place - k as f64).abs() > SAME_STEPS)),
                }
            }
        }
    }
}
