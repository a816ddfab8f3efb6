//! The worst operations are kept as recordings of what they were.

use std::fs;
use std::path::Path;

use bus::message::{ToolPose, Tracked};
use geometry::Point;
use recorder::read::reader::poses;
use recorder::read::verify::verify;
use recorder::replay::facts::facts_of_all;
use study::plan::Plan;
use study::record::Row;
use study::run::run;
use study::worst::{Kept, keep, worst};

use crate::support::six;

fn all(path: &Path, topic: &str) -> Vec<ToolPose> {
    poses(path, topic).unwrap().map(Result::unwrap).collect()
}

fn study(folder: &Path) -> (Plan, Vec<Row>, Vec<Kept>) {
    let plan = six();
    let rows = run(&plan, folder, 2).unwrap().rows;
    let kept = keep(&plan, folder, &rows, 3, 2).unwrap();
    (plan, rows, kept)
}

#[test]
fn a_recording_shows_what_the_line_says() {
    let folder = tempfile::tempdir().unwrap();
    let (plan, rows, kept) = study(folder.path());
    assert_eq!(kept.len(), 3);
    for (one, row) in kept.iter().zip(worst(&plan, &rows, 3)) {
        assert_eq!(
            (&one.stratum, one.number, &one.target),
            (&row.stratum, row.number, &row.target)
        );
        let path = folder.path().join(&one.folder).join("session.mcap");
        let found = verify(&path).unwrap();
        assert!(found.findings.is_empty() && found.messages > 0, "{found:?}");
        assert_eq!(facts_of_all(&path).unwrap().damage, Vec::<String>::new());
        let (shown, truth) = (all(&path, "/tool_pose"), all(&path, "/ground_truth"));
        let emitters = recorder::read::reader::emitters(&path).unwrap().count();
        assert_eq!((shown.len(), emitters), (truth.len(), truth.len()));
        assert!(
            shown
                .windows(2)
                .all(|pair| pair[0].seq < pair[1].seq && pair[0].t_capture_ns < pair[1].t_capture_ns)
        );
        // From 50 ms before the first look to 50 ms before the end, at 60 frames a second.
        assert!(
            (shown.len() as f64 - 60.0 * row.time_s).abs() < 3.0,
            "{} {}",
            shown.len(),
            row.time_s
        );
        let (Some(Ok(Tracked::Valid(last))), Some(Ok(Tracked::Valid(truly)))) =
            (shown.last().map(ToolPose::tracked), truth.last().map(ToolPose::tracked))
        else {
            panic!("the last pose is shown");
        };
        let target = plan.strata[0]
            .targets()
            .into_iter()
            .find(|target| target.name == one.target)
            .unwrap();
        let part = truly.inverse() * target.centre;
        let off = (last * part).distance(target.centre);
        // Both are the same numbers, but for rotations that are made of quaternions.
        assert!((off - row.tre_mm).abs() < 1e-9, "{off} {}", row.tre_mm);
        let tip = truly * Point::new(0.0, 0.0, 0.0);
        // The picture is 50 ms old, and the hand trembles: 20 deviations of 0.07 mm.
        assert!(
            (tip.distance(target.centre) - row.miss_mm).abs() < 1.4,
            "{tip:?} {}",
            row.miss_mm
        );
        assert!(folder.path().join(&one.ct).exists(), "{:?}", one.ct);
        assert!(one.command().starts_with("pilot replay worst/0"), "{}", one.command());
        // The scene finds its examination from where the recording lies.
        let text = fs::read_to_string(path.with_file_name("scene.toml")).unwrap();
        let source = scene::raw::parse_attached(&text, &path).unwrap().scene.volume.source;
        assert_eq!(
            Path::new(&source).canonicalize().unwrap(),
            folder.path().join(&one.ct).canonicalize().unwrap()
        );
    }
}

#[test]
fn the_same_study_keeps_the_same_poses_and_does_none_of_them_twice() {
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let ((plan, rows, kept), (_, _, again)) = (study(one.path()), study(two.path()));
    assert_eq!(kept, again);
    for (own, other) in kept.iter().zip(&again) {
        let folders = [one.path().join(&own.folder), two.path().join(&other.folder)];
        let scenes = folders
            .clone()
            .map(|folder| fs::read(folder.join("scene.toml")).unwrap());
        assert!(scenes[0] == scenes[1]);
        // Attached files name the folders that they were made in.
        for topic in ["/tool_pose", "/ground_truth"] {
            let poses = folders.clone().map(|folder| all(&folder.join("session.mcap"), topic));
            assert!(poses[0] == poses[1] && poses[0].len() > 100, "{topic}");
        }
    }
    let path = one.path().join(&kept[0].folder).join("session.mcap");
    fs::write(&path, "kept").unwrap();
    keep(&plan, one.path(), &rows, 3, 1).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "kept");
    // A line that is not what the operation comes to is found out.
    fs::remove_dir_all(one.path().join(&kept[0].folder)).unwrap();
    let mut others = rows.clone();
    let row = others
        .iter_mut()
        .find(|row| row.stratum == kept[0].stratum && row.number == kept[0].number && row.target == kept[0].target);
    row.unwrap().nees += 1e-9;
    let error = keep(&plan, one.path(), &others, 3, 1).unwrap_err().to_string();
    assert!(error.contains("done once more it is another operation"), "{error}");
}
