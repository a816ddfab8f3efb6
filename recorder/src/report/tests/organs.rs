//! What a report says of organs that a model moved.

use bus::message::{TissueHeader, TissueState};

use super::*;
use crate::wire::proto::TissueFrame;

const MOVES: &str = "seed = 5\n[tissue]\norgans = \"o.toml\"\ntolerance = 0.02\n";
/// Free forces over those of contact, of every state.
const RESIDUAL: f64 = 0.01;
const REPORT: &str = r#"{"trocar_version": "0.2.0", "problems": [], "tissue": {"images": {"settled": 5, "approximate": 2, "late": 1, "refused": 3, "of a later version": 90},
    "covered_twice": 4, "refused_because": {"draw it back <b>": 3}}}"#;

/// A recording with this scene and this report of its run, where there are some, and states that came so far with these forces, N.
fn recorded(scene: &str, report: Option<&str>, states: &[(u32, f64)]) -> Rig {
    let mut log = PoseLog::new(io::Cursor::new(Vec::new()), scene::Compression::Zstd, &[]).unwrap();
    log.scene(scene, 0).unwrap();
    log.facts(&testing::facts()).unwrap();
    poses(&mut log, 0..60, |_| None);
    for (seq, (state, newton)) in (0..).zip(states) {
        let header = TissueHeader {
            seq,
            pose_seq: seq,
            t_capture_ns: testing::pose(seq).t_capture_ns,
            state: *state,
            least_determinant: 0.4,
            residual: RESIDUAL,
            force: [0.6 * newton, 0.0, -0.8 * newton],
            ..TissueHeader::default()
        };
        let nodes = Vec::new();
        log.put(Entry::Tissue(&proto::TissueState::from(&TissueFrame { header, nodes })))
            .unwrap();
    }
    if let Some(report) = report {
        log.attach("report.json", "application/json", report.as_bytes(), 0)
            .unwrap();
    }
    Rig::of(ended(log))
}

fn said_of<'a>(facts: &'a Value, word: &str) -> &'a str {
    let notices = facts["notices"].as_array().unwrap();
    let found = notices.iter().find(|notice| notice["word"] == word);
    found.map_or("", |notice| notice["words"].as_str().unwrap())
}

/// Nothing on the page told that images had shown organs where a model had them.
#[test]
fn images_with_organs_moved_by_a_model_are_told_at_the_top_and_counted() {
    let [settled, approximate] = [TissueState::Settled, TissueState::Approximate].map(TissueState::code);
    let states = [(settled, 0.5), (settled, 2.0), (settled, 1.0), (approximate, 7.0)];
    let (page, facts) = recorded(MOVES, Some(REPORT), &states).said();
    let model = said_of(&facts, "MODEL");
    assert!(
        model
            .contains("Of 11 first images of a pose in the whole run 7 did, 2 of them by a state that had not settled"),
        "{model}"
    );
    assert!(said_of(&facts, "TISSUE COVERED TWICE").starts_with("On 4 images"));
    assert_eq!(
        facts["organs"]["states"],
        serde_json::json!({"settled": 3, "approximate": 1})
    );
    // The largest is of a settled state, that of the second pose.
    let force = &facts["organs"]["largest_force"];
    assert!((force["newton"].as_f64().unwrap() - 2.0).abs() < 1e-12, "{force}");
    assert_eq!(force["t_ns"], testing::pose(1).t_capture_ns);
    let section = page.split_once("Organs that the tube moves, by a model").unwrap().1;
    for words in [
        "<td>settled</td><td>where a state in balance has them</td><td>5</td>",
        "<td>late</td><td>at rest, as no state came in time</td><td>1</td>",
        "draw it back &lt;b&gt;",
        "3 settled",
        "2.00 N at ",
    ] {
        assert!(section.contains(words), "{words}: {section}");
    }
}

#[test]
fn what_images_showed_is_not_known_without_the_runs_own_report() {
    let (page, facts) = recorded(MOVES, None, &[(TissueState::Settled.code(), 0.5)]).said();
    let model = said_of(&facts, "MODEL");
    assert!(
        model.contains("How many images did is not known") && model.contains("1 settled states"),
        "{model}"
    );
    assert!(page.contains("What images showed is <strong>not known</strong>"));
    // Whatever the scene says: states or counts alone tell that a model had a part in it.
    for (report, states) in [(Some(REPORT), &[][..]), (None, &[(TissueState::Lost.code(), 0.0)])] {
        let (_, facts) = recorded("seed = 5\n", report, states).said();
        assert!(words(&facts).contains(&"MODEL"), "{:?}", words(&facts));
    }
}

#[test]
fn a_run_without_organs_is_told_nothing_of_them_and_a_state_that_is_none_is_unreadable() {
    let (page, facts) = recorded("seed = 5\n", None, &[]).said();
    assert!(!words(&facts).contains(&"MODEL") && !page.contains("by a model"));
    // One that its own certificate denies counted as settled, with its force.
    let denied = [
        (TissueState::Settled.code(), f64::NAN),
        (TissueState::Settled.code(), 1.0),
    ];
    let (_, facts) = recorded(MOVES, None, &denied).said();
    assert_eq!(
        (&facts["damage"]["unreadable"], &facts["organs"]["states"]["settled"]),
        (&1.into(), &1.into())
    );
    // The scene's tolerance counts, and not what any scene may have: its residual is 0.01.
    let states = [(TissueState::Settled.code(), 1.0)];
    for (tolerance, settled) in [("0.001", Value::Null), ("0.02", 1.into())] {
        let scene = MOVES.replace("0.02", tolerance);
        let (_, facts) = recorded(&scene, None, &states).said();
        assert_eq!(facts["organs"]["states"]["settled"], settled, "{scene}");
    }
    let (_, facts) = recorded(MOVES, None, &[(99, 0.5)]).said();
    assert_eq!(facts["damage"]["unreadable"], 1);
    assert!(
        facts["damage"]["words"].to_string().contains("state 99"),
        "{}",
        facts["damage"]
    );
}
