//! Links on which an earlier law lied, each with what it did.

use super::super::Settings;
use super::links::{ETHERNET, POLLED, Plan, STEPPED};
use super::study::Study;

fn study(plan: &Plan, seed: u64) -> Study {
    Study::of(&plan.link(seed), Settings::default())
}

/// Three late frames in front of the step were taken into the new law, which was 16 ms too early for a second.
#[test]
fn frames_from_before_a_stamp_that_went_back_are_no_part_of_the_new_law() {
    for seed in [30, 38] {
        for (_, by_ns) in study(&STEPPED[2], seed).steps {
            assert!((by_ns + 80_000_000).abs() < 4_000_000, "{by_ns}");
        }
    }
}

/// A link that lets go of held frames one by one lowered the law by less than 3 ms each time, and the step was not told.
#[test]
fn a_step_behind_a_busy_link_is_told() {
    for forward_s in [5e-3, 20e-3] {
        let steps: &'static [(f64, f64)] = if forward_s < 10e-3 {
            &[(50.0, 5e-3)]
        } else {
            &[(50.0, 20e-3)]
        };
        let plan = Plan {
            rate_hz: 1000.0,
            length_s: 60.0,
            steps,
            ..ETHERNET
        };
        for seed in 0..2 {
            let told = study(&plan, seed).steps;
            let sizes: Vec<f64> = told.iter().map(|(_, by)| *by as f64 * 1e-9 - forward_s).collect();
            assert!(sizes.len() == 1 && sizes[0].abs() < 0.2e-3, "{told:?}");
        }
    }
}

/// Half of the frames were ahead of the law, the others kept it, and it stayed for ever.
#[test]
fn a_law_that_every_other_frame_is_ahead_of_is_given_up() {
    let steps = &[(60.0, 10e-3)];
    let study = study(&Plan { steps, ..POLLED }, 0);
    assert_eq!(study.steps.len(), 1, "{:?}", study.steps);
    assert!(study.error_quantile(0.99, 62.0) < 1e6);
}

/// Nine frames hold a least delay only roughly where delays are spread wide: those below were refused as ahead of the law for ever.
#[test]
fn a_law_that_began_too_late_comes_down() {
    let wide = Plan {
        rate_hz: 20.0,
        delay: |_, chance| 50e-3 * chance.uniform(1),
        ..POLLED
    };
    for seed in 0..3 {
        let study = study(&wide, seed);
        assert_eq!(study.steps, []);
        assert!(study.error_quantile(0.99, 20.0) < 5e6);
        assert!(study.covered as f64 >= 0.99 * study.mapped as f64 && study.mapped > 3500);
    }
}
