//! What is written while a run goes on, and what a result says of where it came from.

use nalgebra::Matrix3;
use serde_json::Value;

use super::super::Space;
use super::READ;
use super::maps::{SCENE, folder};

/// The standard's own example: the SHA-256 of "abc".
const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

#[test]
fn every_state_is_kept_as_it_is_found() {
    let (folder, path) = folder(&Matrix3::identity(), 0.0);
    let space = Space::new(SCENE.to_owned(), &path, None, READ).unwrap();
    let out = folder.path().join("out");
    std::fs::create_dir(&out).unwrap();
    // A line is told before its state is written: at each the states before are there.
    let mut seen = Vec::new();
    let mut look = |_: &str| {
        let json = std::fs::read(out.join("result.json")).ok();
        seen.push(json.map(|json| serde_json::from_slice::<Value>(&json).unwrap()));
    };
    space.run(&out, &mut look).unwrap();
    assert!(seen.len() == 3 && seen[0].is_none());
    for (k, json) in seen.iter().enumerate().skip(1) {
        let json = json.as_ref().unwrap();
        assert_eq!(json["complete"], false);
        assert_eq!(json["equilibria"], false);
        assert_eq!(json["states"].as_array().unwrap().len(), k);
    }
    let json: Value = serde_json::from_slice(&std::fs::read(out.join("result.json")).unwrap()).unwrap();
    assert!(json["complete"] == true && json["states"].as_array().unwrap().len() == 3);
    let files: Vec<_> = std::fs::read_dir(&out)
        .unwrap()
        .map(|f| f.unwrap().file_name())
        .collect();
    assert!(
        !files.iter().any(|f| f.to_string_lossy().ends_with(".part")),
        "{files:?}"
    );
}

#[test]
fn a_result_says_where_it_came_from() {
    let (folder, path) = folder(&Matrix3::identity(), 0.0);
    assert_eq!(organs::sha::of(b"abc"), ABC);
    let map = folder.path().join("ball.nii");
    let sha = organs::sha::of_file(&map).unwrap().unwrap();
    assert_eq!(sha, organs::sha::of(&std::fs::read(&map).unwrap()));
    assert_eq!(organs::sha::of_file(folder.path()).unwrap(), None);
    let pinned = |sha: &str| {
        SCENE.replace(
            "labels = \"ball.nii\"",
            &format!("labels = \"ball.nii\"\nlabels_sha256 = \"{sha}\""),
        )
    };
    assert!(Space::new(pinned(&sha.to_uppercase()), &path, None, READ).is_ok());
    let error = Space::new(pinned(ABC), &path, None, READ).err().unwrap();
    for words in ["space.labels_sha256", "ball.nii", &sha, ABC, "line "] {
        assert!(error.contains(words), "{words} is not in {error}");
    }
    // Another file by the command line is another file too.
    let other = folder.path().join("other.nii");
    let mut bytes = std::fs::read(&map).unwrap();
    if let Some(last) = bytes.last_mut() {
        *last ^= 3;
    }
    std::fs::write(&other, bytes).unwrap();
    let error = Space::new(pinned(&sha), &path, Some(&other), READ).err().unwrap();
    assert!(
        error.contains("other.nii") && error.contains("space.labels_sha256"),
        "{error}"
    );
    let space = Space::new(SCENE.replace("stroke = 4.0", "stroke = 1.0"), &path, None, READ).unwrap();
    space.run(folder.path(), &mut |_| {}).unwrap();
    let json: Value = serde_json::from_slice(&std::fs::read(folder.path().join("result.json")).unwrap()).unwrap();
    assert_eq!(json["labels"]["sha256"], sha);
    let text = json["scene"]["text"].as_str().unwrap();
    assert_eq!(json["scene"]["sha256"], organs::sha::of(text.as_bytes()));
    let organ = &json["organs"][0];
    assert!(organ["law"] == "neo-hookean" && organ["young"] == 0.01 && organ["poisson"] == 0.45);
    assert!(organ["smoothing"] == 3.0 && organ["cubes"]["levels"] == 1 && organ["young_spread"].is_null());
    // Of a ball the level of the same volume is the ball: voxels of other shapes change sides.
    assert!(organ["voxels_smoothed_away"] == 0 && organ["voxels_smoothed_in"] == 0);
    assert!(organ["filled_voxels"] == 0 && organ["open_hole_voxels"] == 0);
    assert_eq!(json["warnings"], serde_json::json!([]));
}

#[test]
fn attachments_at_the_same_place_are_told() {
    let (_folder, path) = folder(&Matrix3::identity(), 0.0);
    let twice = SCENE.replace(
        "[surroundings]",
        "[[attachments]]\norgan = \"ball\"\nto = [\"floor\"]\nwithin = 6.0\nkind = \"tied\"\nyoung = 1e-3\nmargin = 5.0\n\n[surroundings]",
    );
    let words = Space::new(twice, &path, None, READ).unwrap().described();
    println!("{words}");
    let warned = words.lines().find(|line| line.starts_with("WARNING")).unwrap();
    assert!(warned.contains("attachments.0 and attachments.1 both hold") && warned.contains("\"ball\""));
    assert!(!warned.contains("hold 0 points"));
    assert!(
        !Space::new(SCENE.to_owned(), &path, None, READ)
            .unwrap()
            .described()
            .contains("WARNING")
    );
}
