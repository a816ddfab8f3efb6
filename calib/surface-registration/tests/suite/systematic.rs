//! What residuals go with: a slow drift of the bone, tissue under the tip on one side, a second surface.

use geometry::{Ct, Tracker};
use surface_registration::{Limits, Options, Points, Refusal, Start, SurfaceRegistration, register};

use crate::common::change::{drifting, in_order, one_sided, raised};
use crate::common::draw::{Drawn, Sweep, off, rms, targets, tre_mm};
use crate::common::scene::{Scene, scene};

fn touched(points: usize) -> Sweep {
    Sweep {
        points,
        outliers: 0.0,
        sigma_mm: [0.4; 3],
        has_beams: false,
        ..Sweep::default()
    }
}

/// What became of one run.
struct Judged {
    found: SurfaceRegistration<Ct, Tracker>,
    refusals: Vec<Refusal>,
    /// Root mean squares over the targets, mm.
    tre: f64,
    predicted: f64,
}

impl Scene {
    fn judged(&self, drawn: &Drawn, side_mm: f64) -> Judged {
        let points = Points::new(&drawn.points, None, 0.5).unwrap();
        let start = Start::Guess {
            pose: off(drawn, 8.0, 8.0, 5),
            turn_rad: 0.2,
            shift_mm: 10.0,
        };
        let mut options = Options::default();
        (options.priors.bone_mm, options.priors.side_mm) = (0.0, side_mm);
        let found = register(&self.surface, &self.field, &points, &start, &options).unwrap();
        let predicted = targets().map(|target| found.predicted_tre_mm(target));
        Judged {
            refusals: Limits::default().judge(&found, &targets()),
            tre: rms(&tre_mm(
                &found.transform.transform(),
                &drawn.ct_from_tracker,
                &targets(),
            )),
            predicted: rms(&predicted),
            found,
        }
    }
}

/// How many are refused, and how many of those with this refusal; of those that are taken none is off by more than `most` of what is predicted.
fn counted(runs: impl Iterator<Item = Judged>, is_it: impl Fn(&Refusal) -> bool, most: f64) -> [usize; 2] {
    let mut counted = [0; 2];
    for (run, judged) in runs.enumerate() {
        if judged.refusals.is_empty() {
            let ratio = judged.tre / judged.predicted;
            assert!(ratio < most, "{run}: {} mm, {} predicted", judged.tre, judged.predicted);
        }
        counted[0] += usize::from(!judged.refusals.is_empty());
        counted[1] += usize::from(judged.refusals.iter().any(&is_it));
    }
    counted
}

/// The pose takes most of a slow drift, and no residual was looked at against the order of the points: 16 of 20 were taken.
#[test]
fn a_bone_that_drifted_slowly_is_refused() {
    let Some(scene) = scene() else { return };
    let run = |seed: u64| {
        let mut drawn = scene.source.draw(&touched(100), seed);
        drifting(&mut drawn, 2.0, seed);
        scene.judged(&drawn, 0.0)
    };
    let is_it = |refusal: &Refusal| matches!(refusal, Refusal::Drifted { .. });
    // Of 80 of the bench 79 are.
    let [refused, drifted] = counted((100..108).map(run), is_it, 3.0);
    assert!(refused >= 7 && drifted >= 7, "{refused} {drifted}");
    let told = run(100)
        .refusals
        .iter()
        .find(|refusal| is_it(refusal))
        .unwrap()
        .to_string();
    assert!(
        told.contains("the bone slid by some") && told.contains("under the reference"),
        "{told}"
    );
}

/// Nine of twenty were taken, with 1.4 mm of error where 0.47 were stated.
#[test]
fn soft_tissue_on_one_side_is_refused_or_in_the_error() {
    let Some(scene) = scene() else { return };
    let run = |seed: u64| {
        let mut drawn = scene.source.draw(&touched(100), seed);
        one_sided(&mut drawn, &scene.surface, 1.5, seed);
        scene.judged(&drawn, 0.0)
    };
    let is_it = |refusal: &Refusal| matches!(refusal, Refusal::OneSided { .. });
    let [refused, one_sided] = counted((100..108).map(run), is_it, 3.2);
    assert!(refused >= 4 && one_sided >= 3, "{refused} {one_sided}");
}

/// A pose between bone and tissue fits three fifths of the points, with the others a little off it: 8 of 20 were taken, up to 6.6 mm off.
#[test]
fn points_a_little_off_the_bone_are_a_second_surface() {
    let Some(scene) = scene() else { return };
    let run = |seed: u64| {
        let mut drawn = scene.source.draw(&touched(100), seed);
        raised(&mut drawn, &scene.surface, 3.0, |i, _| i % 5 < 2);
        scene.judged(&drawn, 0.0)
    };
    let is_it = |refusal: &Refusal| matches!(refusal, Refusal::SecondSurface(_));
    let [refused, second] = counted((100..108).map(run), is_it, 0.0);
    assert_eq!((refused, second), (8, 8));
    let told = run(100);
    let second = told.found.second.unwrap();
    // 40 were raised, by 3 mm of which a wrong pose shows a part on either side.
    assert!(
        (20..=45).contains(&second.points) && (1.5..4.0).contains(&second.mm),
        "{second:?}"
    );
}

/// In whatever order, with gross errors, none of what is right is refused for what residuals go with.
#[test]
fn what_is_right_has_no_trend() {
    let Some(scene) = scene() else { return };
    let is_it = |refusal: &Refusal| {
        matches!(
            refusal,
            Refusal::Drifted { .. } | Refusal::OneSided { .. } | Refusal::SecondSurface(_)
        )
    };
    for seed in 100..106 {
        for sweep in [
            touched(60),
            Sweep {
                outliers: 0.2,
                ..touched(100)
            },
            Sweep::default(),
        ] {
            let judged = scene.judged(&in_order(scene.source.draw(&sweep, seed)), 0.0);
            let wrong: Vec<String> = judged
                .refusals
                .iter()
                .filter(|r| is_it(r))
                .map(Refusal::to_string)
                .collect();
            assert!(wrong.is_empty(), "{seed} {sweep:?}: {wrong:?}");
            assert!(judged.found.drift.is_some() && judged.found.side.is_some());
        }
    }
}

/// What the residuals cannot show is in the error where it is told: a mm on half of the points, sides being drawn.
#[test]
fn tissue_that_was_told_is_in_the_error() {
    let Some(scene) = scene() else { return };
    let target = targets()[0];
    let drawn = scene.source.draw(&touched(100), 100);
    let clean = scene.judged(&drawn, 0.0);
    let told = scene.judged(&drawn, 1.0);
    assert_eq!(clean.found.transform.transform(), told.found.transform.transform());
    let [clean_mm, told_mm] = [&clean, &told].map(|judged| judged.found.predicted_tre_mm(target));
    let seen = drawn.ct_from_tracker.inverse() * target;
    let shown = clean.found.transform.transform() * seen;
    let runs = 24;
    let square = |seed: u64| {
        let mut drawn = scene.source.draw(&touched(100), 100);
        one_sided(&mut drawn, &scene.surface, 1.0, seed);
        (scene.judged(&drawn, 0.0).found.transform.transform() * seen)
            .distance(shown)
            .powi(2)
    };
    let moved = ((0..runs).map(square).sum::<f64>() / f64::from(runs as u32)).sqrt();
    let added = (told_mm.powi(2) - clean_mm.powi(2)).sqrt();
    // A mean square of 24 scatters by a fifth of itself; 13 directions stand for all, and a cut through the median for one through the mean.
    assert!((added / moved - 1.0).abs() < 0.4, "{added} {moved}");
}
