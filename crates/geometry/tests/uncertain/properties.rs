//! Laws of uncertain transforms, and which numbers are refused as a covariance.

use crate::support::Chance;
use geometry::rotation::Rotation;
use geometry::uncertain::CovarianceError;
use geometry::{Ct, Point, Reference, Rigid, Tool, Tracker, Uncertain, UncertainPoint};
use nalgebra::{Matrix3, Matrix6};
use proptest::prelude::*;

fn uncertain<A, B>(chance: &mut Chance, size_mm: f64) -> Uncertain<A, B> {
    let l = chance.factor(1e-3, 0.3);
    Uncertain::new(chance.rigid(size_mm), l * l.transpose()).unwrap()
}

/// Entries differ by no more than the stated rounding: 32 eps times the sums of absolute products, which `levers` lever
/// arms of `size_mm` make of variances of 6e-6 rad^2 and 0.54 mm^2; rows of turns have no lever.
fn same(a: Matrix6<f64>, b: Matrix6<f64>, size_mm: f64, levers: i32) -> Result<(), TestCaseError> {
    let reach = f64::from(levers) * size_mm * 3.0;
    for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
        let size = |k: usize| if k < 3 { 3e-3 } else { 0.9 + 3e-3 * reach };
        let bound = 128.0 * f64::EPSILON * f64::from(levers) * size(i) * size(j);
        let error = (a[(i, j)] - b[(i, j)]).abs();
        prop_assert!(error <= bound, "{i} {j}: {error:e}, allowed {bound:e}");
    }
    Ok(())
}

proptest! {
    #[test]
    fn the_inverse_of_the_inverse_is_the_same(seed: u64, exponent in 0..=6) {
        let size_mm = 10f64.powi(exponent);
        let a: Uncertain<Ct, Tracker> = uncertain(&mut Chance(seed), size_mm);
        same(a.inverse().inverse().covariance(), a.covariance(), size_mm, 2)?;
    }

    #[test]
    fn composition_is_associative(seed: u64, exponent in 0..=6) {
        let size_mm = 10f64.powi(exponent);
        let mut chance = Chance(seed);
        let a: Uncertain<Ct, Reference> = uncertain(&mut chance, size_mm);
        let b: Uncertain<Reference, Tracker> = uncertain(&mut chance, size_mm);
        let c: Uncertain<Tracker, Tool> = uncertain(&mut chance, size_mm);
        same(((a * b) * c).covariance(), (a * (b * c)).covariance(), size_mm, 3)?;
    }

    #[test]
    fn exact_transforms_carry_by_the_adjoint(seed: u64, exponent in 0..=6) {
        let size_mm = 10f64.powi(exponent);
        let mut chance = Chance(seed);
        let a: Rigid<Ct, Tracker> = chance.rigid(size_mm);
        let b: Uncertain<Tracker, Tool> = uncertain(&mut chance, size_mm);
        let adjoint = a.adjoint();
        prop_assert_eq!((a * b).covariance(), (Uncertain::from(a) * b).covariance());
        same((a * b).covariance(), adjoint * b.covariance() * adjoint.transpose(), size_mm, 2)?;
        // An error before the transform costs what the same error costs after it, and an exact one nothing.
        let back: Uncertain<Ct, Tracker> = a * b * b.transform().inverse();
        same(back.covariance(), (a * b).covariance(), size_mm, 1)?;
        // The product of adjoints is the adjoint of the product.
        let chained = (a * b.transform()).adjoint() - adjoint * b.transform().adjoint();
        prop_assert!(chained.amax() <= 64.0 * f64::EPSILON * (1.0 + 4.0 * size_mm));
    }

    #[test]
    fn the_error_of_a_and_back_is_twice_that_of_a(seed: u64) {
        let a: Uncertain<Ct, Tracker> = uncertain(&mut Chance(seed), 100.0);
        let there_and_back = a * a.inverse();
        same(there_and_back.covariance(), a.covariance() * 2.0, 100.0, 2)?;
    }

    #[test]
    fn triangles_come_back_bit_for_bit(seed: u64) {
        let a: Uncertain<Ct, Tracker> = uncertain(&mut Chance(seed), 100.0);
        prop_assert_eq!(Uncertain::from_upper(a.transform(), a.upper()), Ok(a));
    }

    /// What is carried is still a covariance at the door, where levers do not drown it.
    #[test]
    fn what_is_carried_is_accepted(seed: u64) {
        let mut chance = Chance(seed);
        let (a, b): (Uncertain<Ct, Tracker>, Uncertain<Tracker, Tool>) =
            (uncertain(&mut chance, 300.0), uncertain(&mut chance, 300.0));
        let chain = a * b;
        prop_assert!(Uncertain::from_upper(chain.transform(), chain.upper()).is_ok());
        let image = chain * Point::new(1.0, 2.0, 300.0);
        prop_assert!(UncertainPoint::new(image.point(), image.covariance()).is_ok());
    }
}

fn refused(change: impl Fn(&mut Matrix6<f64>)) -> CovarianceError {
    let mut c = Matrix6::identity();
    change(&mut c);
    Uncertain::<Ct, Tool>::new(Rigid::identity(), c).unwrap_err()
}

#[test]
fn what_is_no_covariance_is_refused_by_name() {
    for bad in [f64::NAN, f64::INFINITY] {
        let error = refused(|c| c[(1, 4)] = bad);
        assert!(
            matches!(error, CovarianceError::NotFinite { row: 1, column: 4, .. }),
            "{error}"
        );
    }
    let error = refused(|c| c[(3, 3)] = -1e-300);
    assert_eq!(
        error,
        CovarianceError::NegativeVariance {
            index: 3,
            found: -1e-300
        }
    );
    let error = refused(|c| c[(0, 5)] = 1e-12);
    assert!(
        matches!(error, CovarianceError::Asymmetric { row: 0, column: 5, .. }),
        "{error}"
    );
    // A correlation beyond 1, one beside a variance of zero, and three that cannot go together.
    let both = |c: &mut Matrix6<f64>, i: usize, j: usize, x: f64| {
        c[(i, j)] = x;
        c[(j, i)] = x;
    };
    let semidefinite = |error| matches!(error, CovarianceError::NotSemidefinite { .. });
    assert!(semidefinite(refused(|c| both(c, 1, 2, 1.001))));
    assert!(semidefinite(refused(|c| {
        c[(2, 2)] = 0.0;
        both(c, 1, 2, 1e-200);
    })));
    assert!(semidefinite(refused(|c| [(0, 1), (1, 2), (0, 2)]
        .into_iter()
        .for_each(|(i, j)| both(c, i, j, -0.6)))));
}

#[test]
fn what_is_a_covariance_is_accepted() {
    let rigid = Rigid::<Ct, Tool>::identity();
    for scale in [0.0, 5e-324, 1e-300, 1.0, 1e300] {
        let c = Matrix6::from_fn(|_, _| scale);
        assert_eq!(Uncertain::new(rigid, c).unwrap().covariance(), c, "{scale:e}");
    }
    // Of rank one, units 1e-9 rad beside 1e3 mm.
    let e = nalgebra::Vector6::new(1e-9, -3e-9, 2e-9, 1e3, 0.0, -2e3);
    assert!(Uncertain::new(rigid, e * e.transpose()).is_ok());
}

/// A turn of 1e-4 rad at 1e6 mm is 100 mm there; the point that is turned about stays.
#[test]
fn levers() {
    let mut c = Matrix6::zeros();
    c[(2, 2)] = 1e-8;
    let far: Rigid<Ct, Tool> = Rigid::from_parts(Rotation::IDENTITY, geometry::Vector::new(1e6, 0.0, 0.0));
    let uncertain = Uncertain::new(far, c).unwrap();
    let image = uncertain * Point::new(0.0, 0.0, 0.0);
    let want = Matrix3::from_diagonal(&nalgebra::Vector3::new(0.0, 1e4, 0.0));
    assert!((image.covariance() - want).amax() <= 1e4 * 4.0 * f64::EPSILON);
    assert!((image.rms_mm() - 100.0).abs() <= 100.0 * 4.0 * f64::EPSILON);
    // sqrt of the 0.95 quantile of chi-square with 3 degrees of freedom, 2.795483...
    assert!((image.radius_95_mm() / 100.0 - 2.795_483_483).abs() < 1e-9);
    let still = uncertain * Point::new(-1e6, 0.0, 0.0);
    assert_eq!(still.covariance(), Matrix3::zeros());
}
