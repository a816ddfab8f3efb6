//! What must not depend on how the views were taken or numbered.

use super::*;
use geometry::{Rigid, Vector};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Isotropic noise has no axes: moving every view anywhere leaves the marker as it is.
    #[test]
    fn views_may_be_moved(seed in 0_u64..1000, w in prop::array::uniform3(-1.8..1.8), t in prop::array::uniform3(-1e3..1e3)) {
        let mut random = Random::new(seed);
        let poses = poses(&mut random, 30);
        let views = seen(&mut random, &ball(24, 30.0), &poses, [SIGMA; 3]);
        let by: Rigid<Tracker, Tracker> =
            Rigid::from_rotation_vector(Vector::new(w[0], w[1], w[2]), Vector::new(t[0], t[1], t[2])).unwrap();
        let moved: Vec<View> = views.iter().map(|v| v.iter().map(|(i, p)| (*i, by * *p)).collect()).collect();
        let (Ok(a), Ok(b)) = (calibrate(&views, 24, &options()), calibrate(&moved, 24, &options())) else {
            // Both or neither hang together.
            prop_assert!(calibrate(&views, 24, &options()).is_err() && calibrate(&moved, 24, &options()).is_err());
            return Ok(());
        };
        let b: Vec<Point<Marker>> = b.emitters.iter().flatten().copied().collect();
        // Both iterations end at a step of 1e-11 of 30 mm; views are rounded at 3000 mm.
        prop_assert!(rms(&errors(&a.emitters, &b)) < 1e-9);
    }

    /// The order of views, and of sightings in them, says nothing.
    #[test]
    fn the_order_says_nothing(seed in 0_u64..1000, turn in 1_usize..29) {
        let mut random = Random::new(seed);
        let poses = poses(&mut random, 30);
        let views = seen(&mut random, &ball(24, 30.0), &poses, [SIGMA; 3]);
        let mut other = views.clone();
        other.rotate_left(turn);
        other.iter_mut().for_each(|v| v.reverse());
        let (Ok(a), Ok(b)) = (calibrate(&views, 24, &options()), calibrate(&other, 24, &options())) else {
            return Ok(());
        };
        let b: Vec<Point<Marker>> = b.emitters.iter().flatten().copied().collect();
        prop_assert!(rms(&errors(&a.emitters, &b)) < 1e-9);
    }
}
