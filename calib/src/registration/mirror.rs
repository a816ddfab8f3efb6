//! Whether the points tell a body from its mirror image.

use geometry::{Frame, Vector};

use super::jacobi::symmetric3;
use super::pairs::vector;
use super::{Fit, Noise, Registration};

/// How far a mirror image must fit worse, in deviations of the noise, before the points are said to tell it apart.
const DEVIATIONS: f64 = 5.0;

/// The best improper motion: the plane in `To` that it mirrors the registration through, through the centre of the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mirror<To: Frame> {
    /// Of length 1, to rounding.
    pub normal: Vector<To>,
    /// How much larger than that of the registration its mean squared distance of pairs is, mm^2; below 0 where it fits better.
    pub excess_mm2: f64,
}

impl<To: Frame, From: Frame> Fit<To, From> {
    /// The best improper motion. With the singular values of `Psi` the criterion (4.13) is `s1 + s2 + s3` at the best rotation and `s1 + s2 - s3`
    /// at the best orthogonal map of the other determinant, which turns the third left singular vector over (Umeyama 1991): the mean
    /// squared distances differ by `4 s3`.
    pub fn mirror(&self) -> Mirror<To> {
        let psi = self.moments.correlation();
        let (values, vectors) = symmetric3(psi * psi.transpose());
        let radius_mm = |cloud: usize| self.moments.energy[cloud].max(0.0).sqrt() / self.moments.scale[cloud];
        let [_, _, third] = self.singular_values().0;
        Mirror {
            normal: vector(vectors.column(values.imin()).into_owned()),
            excess_mm2: 4.0 * third * radius_mm(0) * radius_mm(1),
        }
    }
}

impl<To: Frame, From: Frame> Registration<To, From> {
    /// The best improper motion, where pairs of this noise do not tell it from the registration: it fits better, or worse by less than five
    /// deviations, as always with three pairs. Which of the two is the body's then rests on both frames being right-handed alone.
    pub fn undecided_mirror(&self, noise: Noise) -> Option<Mirror<To>> {
        let mirror = self.fit.mirror();
        let n = self.effective as f64;
        let moments = &self.fit.moments;
        // Correlations are rounded by some eps of themselves.
        let rounding = 64.0 * f64::EPSILON * moments.energy[0].max(0.0) / (moments.scale[0] * moments.scale[0]);
        let told = n * (mirror.excess_mm2 - rounding) > (DEVIATIONS * noise.sigma_mm).powi(2);
        (!told).then_some(mirror)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Method, Pairs, register};
    use super::*;
    use geometry::{Ct, Point, Tracker};

    fn points<F>(all: &[[f64; 3]]) -> Vec<Point<F>> {
        all.iter().map(|[x, y, z]| Point::new(*x, *y, *z)).collect()
    }

    /// A mirrored cloud in a plane fits to the last digit, and was not told of.
    #[test]
    fn a_mirror_image_is_told_only_by_points_off_a_plane() {
        let noise = Noise { sigma_mm: 0.3 };
        for (z, is_told) in [(0.0, false), (0.2, false), (20.0, true)] {
            let body = [[-60.0, 0.0, -z], [60.0, 10.0, z], [0.0, 70.0, -z], [30.0, -40.0, z]];
            let swapped = body.map(|[x, y, z]| [y, x, z]);
            let (to, turned) = (
                points::<Ct>(&body),
                points::<Tracker>(&body.map(|[x, y, z]| [-y, x, z])),
            );
            let found = register(Pairs::new(&to, &turned).unwrap(), Method::default()).unwrap();
            let mirror = found.undecided_mirror(noise);
            assert_eq!(mirror.is_none(), is_told, "{z}: {mirror:?}");
            // By the definition: the pairs of a cloud that was mirrored fit by the improper motion.
            let mirrored = register(
                Pairs::new(&to, &points::<Tracker>(&swapped)).unwrap(),
                Method::default(),
            )
            .unwrap();
            let worse = mirrored.fit.mirror().excess_mm2;
            assert!(
                (worse + mirrored.fre_rms_mm.powi(2)).abs() < 1e-9 * 60.0 * 60.0,
                "{worse}"
            );
            assert!(mirrored.undecided_mirror(noise).is_some());
            if z == 0.0 {
                assert!((mirror.unwrap().normal.mm()[2].abs() - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn three_pairs_never_tell_a_mirror_image() {
        let to = [[-60.0, 0.0, 5.0], [60.0, 10.0, -80.0], [0.0, 70.0, 20.0]];
        let from = to.map(|[x, y, z]| [-y, x, z]);
        let found = register(
            Pairs::new(&points::<Ct>(&to), &points::<Tracker>(&from)).unwrap(),
            Method::default(),
        );
        assert!(found.unwrap().undecided_mirror(Noise { sigma_mm: 0.0 }).is_some());
    }
}
