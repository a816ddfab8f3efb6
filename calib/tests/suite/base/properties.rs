//! What must not depend on where the localizer stands.

use super::*;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// A localizer that is moved moves the base and its covariance with it.
    #[test]
    fn the_place_moves_with_the_touches(
        seed in 0_u64..1000,
        w in prop::array::uniform3(-1.8..1.8),
        t in prop::array::uniform3(-1e3..1e3),
    ) {
        let drawing = uneven();
        let touching = Touching { drawing: &drawing, tip_radius: 0.0, sigma: SIGMA, counts: [12, 6] };
        let mut random = Random::new(seed);
        let truth = pose(&mut random);
        let groups = touching.groups(&mut random, truth);
        let by: Rigid<Tracker, Tracker> =
            Rigid::from_rotation_vector(Vector::new(w[0], w[1], w[2]), Vector::new(t[0], t[1], t[2])).unwrap();
        let moved: Vec<Group<Tracker>> = groups
            .iter()
            .map(|g| Group { touches: g.touches.iter().map(|p| by * *p).collect(), ..g.clone() })
            .collect();
        let here = locate(&drawing, &groups, &Options::new(SIGMA)).unwrap();
        let there = locate(&drawing, &moved, &Options::new(SIGMA)).unwrap();
        let carried = by * here.place;
        let e = error(carried.transform(), there.place.transform());
        // Steps end at 1e-12 of the radius; touches are rounded at 3000 mm, and a turn is carried over that.
        prop_assert!(e.fixed_rows::<3>(0).norm() < 1e-11 && e.norm() < 1e-7, "{e}");
        let origin = there.place.transform() * Point::<Base>::new(0.0, 0.0, 0.0);
        let (a, b) = (carried.covariance_about(origin), there.place.covariance_about(origin));
        let scale = Matrix6::from_diagonal(&b.diagonal().map(|x| 1.0 / x.sqrt()));
        // The covariance at the origin is what is left of 3000^2 times that of the turn, 1e-16 of which is lost.
        prop_assert!((scale * (a - b) * scale).amax() < 1e-8);
    }
}
