//! The errors of calibration and registration that a room draws, held against what the chain is told of them.

use super::*;
use crate::chain::Registration;
use geometry::Uncertain;
use nalgebra::Vector6;

const ERRORS: &str = "[tracker.room]\ncalibration_error_mm = 0.1\ncalibration_error_deg = 0.5\n\
    registration_error_mm = 0.3\nregistration_error_deg = 0.2\n";

/// The motion (w, v) that is missing to the truth, squared in units of the stated covariance: chi-squared of 6 degrees.
fn square<To, From>(truth: Rigid<To, From>, stated: &Uncertain<To, From>) -> f64 {
    let motion = truth * stated.transform().inverse();
    let (w, v) = (motion.rotation().vector().radians(), motion.translation_mm());
    let error = Vector6::new(w[0], w[1], w[2], v[0], v[1], v[2]);
    error.dot(&stated.covariance().lu().solve(&error).unwrap())
}

/// The mean over rooms of a number.
fn mean(n: u64, of: impl Fn(u64) -> f64) -> f64 {
    (0..n).map(of).sum::<f64>() / n as f64
}

#[test]
fn drawn_links_err_as_the_chain_is_told() {
    let n = 4000;
    let region = Point::new(40.0, -30.0, 120.0);
    for reference in ["", "[tracker.room.reference]\n"] {
        let scene = scene("", &format!("{ERRORS}{reference}"));
        let chain = |seed| approached(&scene, seed).chain(region).unwrap();
        let marker_from_tool = room(&scene).marker_from_tool;
        let calibration = mean(n, |seed| square(marker_from_tool, &chain(seed).marker_from_tool));
        let registration = mean(n, |seed| match chain(seed).registration {
            Registration::Fixed(stated) => square(scene.tracker.ct_from_tracker, &stated),
            Registration::Referenced(stated) => {
                square(room(&scene).reference.as_ref().unwrap().ct_from_reference, &stated)
            }
        });
        // Chi-squared of 6 degrees has variance 12; five standard errors, and second orders of half a degree.
        let allowed = 5.0 * (12.0 / n as f64).sqrt() + 0.01;
        assert!((calibration - 6.0).abs() < allowed, "{calibration}");
        assert!((registration - 6.0).abs() < allowed, "{registration}");
    }
}

#[test]
fn the_stated_millimetres_are_those_of_the_tip_and_of_the_target() {
    let (n, region) = (4000, Point::new(40.0, -30.0, 120.0));
    let scene = scene("", ERRORS);
    let ct_from_tracker = scene.tracker.ct_from_tracker;
    let off = |seed| {
        let chain = approached(&scene, seed).chain(region).unwrap();
        let tip_off = (chain.marker_from_tool.transform() * tip()).distance(room(&scene).marker_from_tool * tip());
        let Registration::Fixed(stated) = chain.registration else {
            panic!("no reference")
        };
        let target = ct_from_tracker.inverse() * region;
        [tip_off, (stated.transform() * target).distance(region)]
    };
    for (which, stated) in [(0, 0.1), (1, 0.3)] {
        let rms = (mean(n, |seed| off(seed)[which].powi(2)) / 3.0).sqrt();
        // Five standard errors of a deviation from 3 n draws.
        let allowed = 5.0 / (6.0 * n as f64).sqrt();
        assert!((rms / stated - 1.0).abs() < allowed, "{which}: {rms}");
    }
}

#[test]
fn without_errors_the_links_are_the_truth() {
    let scene = scene("", "");
    let chain = approached(&scene, 1).chain(Point::new(40.0, -30.0, 120.0)).unwrap();
    assert_eq!(chain.marker_from_tool, room(&scene).marker_from_tool.into());
    let Registration::Fixed(stated) = chain.registration else {
        panic!("no reference")
    };
    assert_eq!(stated.covariance().amax(), 0.0);
    // The room keeps the inverse; there and back is a few roundings of 2300 mm.
    let ahead = Point::new(0.0, 0.0, 2300.0);
    assert!((stated.transform() * ahead).distance(scene.tracker.ct_from_tracker * ahead) < 5e-12);
}

#[test]
fn weights_have_a_floor_where_there_is_no_noise() {
    let localizer = |lines: &str| approached(&scene(lines, ""), 1).chain(middle()).unwrap().localizer;
    let quiet = localizer(QUIET);
    assert_eq!((quiet.across_mm, quiet.depth_mm), (1e-3, 1e-3));
    let deep = localizer("across_mm = 0\ndepth_mm = 0.5");
    assert_eq!((deep.across_mm, deep.depth_mm), (0.01, 0.5));
    let usual = localizer("");
    assert!((usual.across_mm - 0.1).abs() < 1e-15 && (usual.depth_mm - 0.15).abs() < 1e-15);
}
