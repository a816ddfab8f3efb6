//! Codes, certificates and errors of states of tissue.

use super::*;

#[test]
fn codes_come_back_and_no_other_is_taken() {
    for state in TissueState::ALL {
        let header = TissueHeader {
            state: state.code(),
            ..TissueHeader::default()
        };
        assert_eq!(header.state_of(), Ok(state));
    }
    for shown in TissueShown::ALL {
        assert_eq!(TissueShown::from_code(shown.code()), Some(shown));
    }
    for shown in TargetShown::ALL {
        assert_eq!(TargetShown::from_code(shown.code()), Some(shown));
    }
    assert_eq!(TargetShown::from_code(6), None);
    let unknown = TissueHeader {
        state: 5,
        ..TissueHeader::default()
    };
    assert!(unknown.state_of().unwrap_err().to_string().contains("state 5"));
    assert_eq!(TissueShown::from_code(7), None);
}

/// A state that was altered was drawn as settled, whatever its certificate said.
#[test]
fn a_state_whose_certificate_denies_it_is_none() {
    let settled = TissueHeader {
        state: TissueState::Settled.code(),
        residual: 1e-3,
        depth_mm: 1e-3,
        unsettled_mm: f64::INFINITY,
        least_determinant: 1e-9,
        ..TissueHeader::default()
    };
    assert_eq!(settled.certified(1e-3), Ok(TissueState::Settled));
    let set = |what: &str, value: f64| {
        let mut header = settled;
        *match what {
            "residual" => &mut header.residual,
            "depth_mm" => &mut header.depth_mm,
            "unsettled_mm" => &mut header.unsettled_mm,
            "least_determinant" => &mut header.least_determinant,
            "force" => &mut header.force[1],
            _ => &mut header.left_mm,
        } = value;
        header
    };
    for (what, values) in [
        ("residual", [1.001e-3, -1e-9, f64::NAN]),
        ("depth_mm", [1.001e-3, f64::INFINITY, f64::NAN]),
        ("unsettled_mm", [-1.0, f64::NEG_INFINITY, f64::NAN]),
        ("least_determinant", [0.0, -0.3, f64::NAN]),
        ("force", [f64::INFINITY, f64::NEG_INFINITY, f64::NAN]),
        ("left_mm", [1e-9, -1.0, f64::NAN]),
    ] {
        for value in values {
            let header = set(what, value);
            let why = header.certified(1e-3).unwrap_err().to_string();
            assert!(
                why.contains(&format!("called settled, and its certificate denies it: {what} is")),
                "{why}"
            );
            // What claims no balance need not have one.
            let approximate = TissueHeader {
                state: TissueState::Approximate.code(),
                ..header
            };
            assert_eq!(approximate.certified(1e-3).is_ok(), what != "left_mm", "{what} {value}");
        }
    }
    let catching = |left_mm| TissueHeader {
        state: TissueState::CatchingUp.code(),
        left_mm,
        ..TissueHeader::default()
    };
    assert_eq!(catching(0.1).certified(1e-3), Ok(TissueState::CatchingUp));
    assert!(catching(0.0).certified(1e-3).is_err() && catching(f64::NAN).certified(1e-3).is_err());
}

#[test]
fn why_a_pose_was_refused_comes_back_whole_characters_only() {
    let header = TissueHeader::default().because("draw it back");
    assert_eq!(header.why(), "draw it back");
    assert_eq!(TissueHeader::default().why(), "");
    let long = "\u{e4}".repeat(100);
    assert_eq!(header.because(&long).why(), "\u{e4}".repeat(80));
    let long = "x".to_owned() + &long;
    assert_eq!(header.because(&long).why().len(), 159);
    let mut bad = header;
    bad.why[0] = u64::MAX;
    assert_eq!(bad.why(), "");
    assert_eq!(header.because("red\u{1b}[31m").why(), "");
}

#[test]
fn an_error_is_that_of_its_place_or_not_known() {
    let error = PlaceError {
        at_rest_mm: [1.0, 2.0, 3.0],
        covariance: [4.0, 1.0, -0.5, 1.0, 0.0, 0.25],
    };
    let mut header = TissueHeader {
        t_capture_ns: 900,
        errors_t_capture_ns: 400,
        errors_known: 1,
        ..TissueHeader::default()
    };
    header.errors[0] = error;
    let whole = [[4.0, 1.0, -0.5], [1.0, 1.0, 0.0], [-0.5, 0.0, 0.25]];
    assert_eq!(header.error_of([1.0, 2.0, 3.0]), Some((whole, 500)));
    // Another place; none told; more than there can be; of a pose to come.
    assert_eq!(header.error_of([1.0, 2.0, 3.5]), None);
    for errors_known in [0, 17, u64::MAX] {
        let header = TissueHeader { errors_known, ..header };
        assert_eq!(header.error_of([1.0, 2.0, 3.0]), None, "{errors_known}");
    }
    let later = TissueHeader {
        errors_t_capture_ns: 901,
        ..header
    };
    assert_eq!(later.error_of([1.0, 2.0, 3.0]), None);
    // What is no covariance is not known, and not small.
    for bad in [
        [f64::NAN, 1.0, -0.5, 1.0, 0.0, 0.25],
        [-4.0, 1.0, -0.5, 1.0, 0.0, 0.25],
        [4.0, 2.1, -0.5, 1.0, 0.0, 0.25],
        [4.0, 1.0, -0.5, 1.0, f64::INFINITY, 0.25],
        [4.0, 1.0, -0.5, 1e7, 0.0, 0.25],
        [4.0, -4.0, -4.0, 4.0, -4.0, 4.0],
    ] {
        header.errors[0].covariance = bad;
        assert_eq!(header.error_of([1.0, 2.0, 3.0]), None, "{bad:?}");
    }
}

#[test]
fn the_force_has_an_error_along_it_or_none_that_is_known() {
    let mut header = TissueHeader {
        force: [0.0, 3.0, 4.0],
        t_capture_ns: 5,
        errors_t_capture_ns: 5,
        force_error_known: 1,
        // Twice as uncertain along the force as is (0, 3, 4) / 5 itself, and far more across it.
        force_covariance: [100.0, 0.0, 0.0, 1.44, 1.92, 2.56],
        ..TissueHeader::default()
    };
    let (size, error) = header.force_95_n();
    assert!(
        size == 5.0 && (error.unwrap() - 2.0 * NORMAL_95).abs() < 1e-12,
        "{error:?}"
    );
    // Across what presses nothing, no direction is the force's.
    let none = TissueHeader {
        force: [0.0; 3],
        ..header
    };
    assert!((none.force_95_n().1.unwrap() - 104.0_f64.sqrt() * NORMAL_95).abs() < 1e-12);
    for other in [
        TissueHeader {
            force_error_known: 0,
            ..header
        },
        TissueHeader {
            force_error_known: 2,
            ..header
        },
        TissueHeader {
            errors_t_capture_ns: 6,
            ..header
        },
    ] {
        assert_eq!(other.force_95_n(), (5.0, None));
    }
    header.force_covariance[3] = -1.44;
    assert_eq!(header.force_95_n(), (5.0, None));
}

#[test]
fn places_are_of_the_mesh_in_use_whole_and_in_a_patient() {
    let header = TissueHeader {
        seq: 7,
        mesh_id: [3; 32],
        ..TissueHeader::default()
    };
    let good = [1.0, 2.0, 3.0, -4.0, 5.0, 1e4];
    let taken = header.places(&good, (&[3; 32], 2)).unwrap();
    assert_eq!(taken, [[1.0, 2.0, 3.0], [-4.0, 5.0, 1e4]]);
    let why = |values: &[f32], id, nodes| header.places(values, (&id, nodes)).unwrap_err().to_string();
    assert!(why(&good, [4; 32], 2).contains("of mesh 03030303; that in use is 04040404"));
    assert!(why(&good[..5], [3; 32], 2).contains("5 coordinates; the mesh has 6"));
    assert!(why(&good, [3; 32], 1).contains("6 coordinates; the mesh has 3"));
    for bad in [f32::NAN, f32::INFINITY, -1.1e4] {
        let mut values = good;
        values[4] = bad;
        assert!(why(&values, [3; 32], 2).contains("coordinate 4"), "{bad}");
    }
}
