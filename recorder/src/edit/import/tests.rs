use std::fs;

use super::*;
use crate::edit::export::{Format, export};
use crate::read::reader;
use crate::testing;
use crate::wire::schema::TOOL_POSE;

const ONE: &str = "1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1";

fn imported(text: &str, transform: Option<&str>) -> Result<(Imported, Vec<ToolPose>), String> {
    let tmp = tempfile::tempdir().unwrap();
    let (input, out) = (tmp.path().join("s.mha"), tmp.path().join("s.mcap"));
    fs::write(&input, text).unwrap();
    let imported =
        import(&input, transform, &out, false).map_err(|e| e.to_string().replace(input.to_str().unwrap(), "s.mha"))?;
    let poses = reader::poses(&out, TOOL_POSE).unwrap().map(Result::unwrap).collect();
    Ok((imported, poses))
}

#[test]
fn frames_are_taken_by_number_status_and_time() {
    let text = format!(
        "ObjectType = Image\nSeq_Frame0001_AToBTransform = 0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1\n\
         Seq_Frame0001_Timestamp = 2.75\nSeq_Frame0000_AToBTransform = {ONE}\nSeq_Frame0000_Timestamp = 2.5\n\
         Seq_Frame0002_AToBTransform = {ONE}\nSeq_Frame0002_AToBTransformStatus = INVALID\n\
         Seq_Frame0002_Timestamp = 3.0\nSeq_Frame0003_Timestamp = 3.25\nElementDataFile = LOCAL\n\u{0}"
    );
    let (imported, poses) = imported(&text, None).unwrap();
    assert_eq!(
        (imported.transform.as_str(), imported.frames, imported.lost),
        ("AToB", 4, 2)
    );
    let times: Vec<_> = poses.iter().map(|pose| pose.t_capture_ns).collect();
    assert_eq!(times, [0, 250_000_000, 500_000_000, 750_000_000]);
    assert_eq!(poses[1].t_device_ns, 2_750_000_000);
    assert_eq!((poses[0].q, poses[0].t_mm), ([1.0, 0.0, 0.0, 0.0], [5.0, 6.0, 7.0]));
    let half = 0.5_f64.sqrt();
    assert!((poses[1].q[0] - half).abs() < 1e-15 && (poses[1].q[3] - half).abs() < 1e-15);
    assert_eq!(poses.iter().map(|pose| pose.status).collect::<Vec<_>>(), [0, 0, 1, 1]);
}

#[test]
fn what_was_exported_comes_back() {
    let tmp = tempfile::tempdir().unwrap();
    let [session, mha, back] = ["s.mcap", "s.mha", "b.mcap"].map(|name| tmp.path().join(name));
    fs::write(&session, testing::finished(2, 30)).unwrap();
    assert_eq!(
        export(&session, TOOL_POSE, Format::Mha, &mha, false).unwrap().messages,
        60
    );
    assert_eq!(
        import(&mha, Some("ToolToCtTransform"), &back, false).unwrap().frames,
        60
    );
    for (seq, pose) in (0..).zip(reader::poses(&back, TOOL_POSE).unwrap().map(Result::unwrap)) {
        let sent = testing::pose(seq);
        assert_eq!((pose.t_capture_ns, pose.t_mm), (sent.t_capture_ns, sent.t_mm));
        // Through a matrix and back: a few roundings of numbers of at most 1; q and -q turn alike.
        let sign = if pose.q[0] * sent.q[0] < 0.0 { -1.0 } else { 1.0 };
        let off = pose
            .q
            .iter()
            .zip(sent.q)
            .map(|(a, b)| (sign * a - b).abs())
            .fold(0.0, f64::max);
        assert!(off < 8.0 * f64::EPSILON, "pose {seq}: {off:e}");
    }
}

#[test]
fn impossible_sequences_are_refused_with_their_line() {
    let end = "\nElementDataFile = LOCAL\n";
    let cases = [
        (
            "Seq_Frame0000_AToBTransform = 1 2 3",
            "s.mha, line 1: 3 numbers of a matrix instead of 16",
        ),
        (
            &format!("Seq_Frame0000_AToBTransform = {ONE} 1"),
            "more than the 16 numbers",
        ),
        (
            &format!("Seq_Frame0000_AToBTransform = {ONE}\nSeq_Frame0000_Timestamp = nan"),
            "s.mha, line 2: found \"nan\" where a number of at most 1e9 belongs",
        ),
        (
            "Seq_Frame0000_AToBTransform = 2 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1",
            "s.mha, line 1: the matrix is not a rotation",
        ),
        (
            "Seq_Frame0000_AToBTransform = 1 0 0 5 0 1 0 6 0 0 1 7 0 0 1 1",
            "the last row of the matrix is [0.0, 0.0, 1.0, 1.0] instead of 0 0 0 1",
        ),
        (
            "ObjectType = Image",
            "which transform is the tool's pose is not said. It has: no transform",
        ),
        (
            &format!("Seq_Frame0000_ATransform = {ONE}\nSeq_Frame0000_BTransform = {ONE}"),
            "It has: A, B. Name one with --transform NAME",
        ),
    ];
    for (text, words) in cases {
        let error = imported(&format!("{text}{end}"), None).unwrap_err();
        assert!(error.contains(words), "{text}: {error}");
    }
    assert!(
        imported("A = B\n", None)
            .unwrap_err()
            .contains("line 2: the file ends before the line ElementDataFile")
    );
    let text = imported(&format!("Seq_Frame0000_ATransform = {ONE}{end}"), Some("X")).unwrap_err();
    assert!(
        text.contains("there is no transform X, and none can be composed of what there is. It has: A"),
        "{text}"
    );
}

#[test]
fn a_chain_is_composed_and_a_frame_without_a_link_is_lost() {
    let at = |frame: u32, name: &str, x: f64, status: &str| {
        format!(
            "Seq_Frame000{frame}_{name}Transform = 0 -1 0 {x} 1 0 0 0 0 0 1 0 0 0 0 1\nSeq_Frame000{frame}_{name}TransformStatus = \
             {status}\nSeq_Frame000{frame}_Timestamp = {frame}\n"
        )
    };
    let lines: String = (0..4)
        .map(|i| {
            let status = |bad: u32| if i == bad { "MISSING" } else { "OK" };
            at(i, "StylusTipToStylus", 7.0, status(3))
                + &at(i, "StylusToTracker", f64::from(i), status(1))
                + &at(i, "ReferenceToTracker", 2.0, status(2))
        })
        .collect();
    let end = "ElementDataFile = LOCAL\n";
    let (imported_, poses) = imported(&(lines.clone() + end), Some("StylusTipToReferenceTransform")).unwrap();
    assert_eq!((imported_.frames, imported_.lost), (4, 3));
    assert!(
        imported_
            .transform
            .contains("StylusTipToStylus, then StylusToTracker, then inverse ReferenceToTracker"),
        "{imported_:?}"
    );
    // Tip to stylus: (7, 0); a quarter turn of that: (0, 7); back from the reference: (-2, 7) turned by -90.
    let [x, y, z] = poses[0].t_mm;
    assert!(
        (x - 7.0).abs() + (y - 2.0).abs() + z.abs() < 1e-12,
        "{:?}",
        poses[0].t_mm
    );
    assert_eq!(poses.iter().map(|pose| pose.status).collect::<Vec<_>>(), [0, 1, 1, 1]);
    let two = lines + &at(0, "StylusToReference", 5.0, "OK") + end;
    let error = imported(&two, Some("StylusTipToReference")).unwrap_err();
    assert!(error.contains("s.mha, frame 0:") && error.contains("apart"), "{error}");
}
