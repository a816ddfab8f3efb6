//! The height at which a fit starts, where slices are thick: the spot's middle is that of a voxel, and half a slice away a mean
//! over the slice has no slope that leads to the centre.

use super::fit::Sample;
use super::profile::Blur;

/// Heights that are tried, as shares of the step between slices.
const START_HEIGHTS: [f64; 5] = [0.0, -0.25, 0.25, -0.5, 0.5];
/// The most voxels that are looked at.
const MAX_VOXELS: usize = 900;

/// Of a few heights over the samples' middle the one at which a ball of any metal on even ground leaves least of the voxels
/// that are not clipped, mm.
pub(super) fn height(samples: &[Sample], blur: &Blur, step_mm: f64) -> f64 {
    let thinned = samples.iter().filter(|s| !s.clipped);
    let every = samples.len().div_ceil(MAX_VOXELS).max(1);
    let open: Vec<&Sample> = thinned.step_by(every).collect();
    let mut best = (f64::INFINITY, 0.0);
    for share in START_HEIGHTS {
        let height = share * step_mm;
        let left = left(&open, |s| blur.value(s.place.xy().norm(), s.place.z - height));
        if left < best.0 {
            best = (left, height);
        }
    }
    best.1
}

/// The sum of squares that a line from `share` to HU leaves, infinite where it does not rise.
fn left(open: &[&Sample], share: impl Fn(&Sample) -> f64) -> f64 {
    let pairs: Vec<[f64; 2]> = open.iter().map(|s| [share(s), s.hu]).collect();
    let n = pairs.len() as f64;
    let mean = [0, 1].map(|k| pairs.iter().map(|p| p[k]).sum::<f64>() / n);
    let moment = |a: usize, b: usize| pairs.iter().map(|p| (p[a] - mean[a]) * (p[b] - mean[b])).sum::<f64>();
    let (across, both) = (moment(0, 0), moment(0, 1));
    // Without a voxel the means are NaN, which is no rise: the middle stays.
    let rises = across > 0.0 && both > 0.0;
    if rises {
        // What a regression on the share leaves of the squares.
        moment(1, 1) - both * both / across
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    #[test]
    fn the_height_is_the_nearest_of_those_tried_and_the_middle_where_nothing_rises() {
        let blur = Blur {
            radius_mm: 1.0,
            plane_mm: 0.45,
            axial_mm: 0.45,
            slice_mm: 4.0,
        };
        let place = |i: i32| {
            Vector3::new(
                f64::from(i % 7 - 3),
                f64::from(i / 7 % 7 - 3),
                4.0 * f64::from(i / 49 - 2),
            )
        };
        let volume = |height: f64, metal: f64, clip: f64| -> Vec<Sample> {
            let one = |i: i32| {
                let place = place(i);
                let hu = 40.0 + metal * blur.value(place.xy().norm(), place.z - height);
                Sample {
                    place,
                    hu: hu.min(clip),
                    clipped: hu >= clip,
                }
            };
            (0..245).map(one).collect()
        };
        for (planted, found) in [(0.1, 0.0), (0.9, 1.0), (-1.2, -1.0), (1.9, 2.0), (-1.8, -2.0)] {
            for clip in [f64::INFINITY, 3071.0] {
                assert_eq!(
                    height(&volume(planted, 14_000.0, clip), &blur, 4.0),
                    found,
                    "{planted} {clip}"
                );
            }
        }
        assert_eq!(height(&volume(0.9, 0.0, 3071.0), &blur, 4.0), 0.0);
        assert_eq!(height(&volume(0.9, -500.0, 3071.0), &blur, 4.0), 0.0);
        assert_eq!(height(&[], &blur, 4.0), 0.0);
    }
}
