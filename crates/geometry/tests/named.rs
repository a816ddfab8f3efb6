//! Chains of named transforms against products by hand, over random graphs.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

use std::collections::{BTreeMap, BTreeSet};

use geometry::named::{Chain, Link, NamedRigid, NoChain};
use geometry::{Rigid, Vector};
use proptest::prelude::*;

fn rigid([a, b, c, x, y, z]: [f64; 6]) -> NamedRigid {
    Rigid::from_rotation_vector(Vector::new(a, b, c), Vector::new(x, y, z)).unwrap()
}

fn apart(a: &NamedRigid, b: &NamedRigid) -> f64 {
    let between = a.inverse() * *b;
    let [x, y, z] = between.translation_mm();
    x.hypot(y).hypot(z) + 1e3 * between.angle()
}

fn found(names: &[&str], asked: &str) -> Result<Chain, NoChain> {
    Chain::find(&names.iter().copied().collect::<BTreeSet<_>>(), asked)
}

fn links(chain: &Chain) -> Vec<String> {
    chain.links().iter().map(Link::to_string).collect()
}

#[test]
fn names_are_parted_where_a_frame_begins() {
    let chain = found(
        &["StylusTipToStylus", "StylusToTracker", "ReferenceToTracker"],
        "StylusTipToReference",
    )
    .unwrap();
    assert_eq!(
        links(&chain),
        ["StylusTipToStylus", "StylusToTracker", "inverse ReferenceToTracker"]
    );
    // `To` that begins a frame's name, or is within it, parts nothing.
    let tools = ["ToolToTracker", "CtToTracker", "TotalToTool", "StorkToTotal"];
    assert_eq!(
        links(&found(&tools, "ToolToCt").unwrap()),
        ["ToolToTracker", "inverse CtToTracker"]
    );
    assert_eq!(
        links(&found(&tools, "CtToStork").unwrap()),
        [
            "CtToTracker",
            "inverse ToolToTracker",
            "inverse TotalToTool",
            "inverse StorkToTotal"
        ]
    );
    // A frame `ToolToArm`: known from no clear name, the name is in no chain; known from others, it is.
    let arm = ["ToolToArmToTracker", "PlanToTracker"];
    assert!(matches!(found(&arm, "ToolToPlan"), Err(NoChain::Missing { .. })));
    let arm = ["ToolToArmToTracker", "PlanToTracker", "ArmToTracker", "TipToTool"];
    let chain = found(&arm, "TipToPlan");
    assert!(matches!(chain, Err(NoChain::Missing { .. })), "{chain:?}");
    // Both readings of what is asked lead somewhere.
    let both = ["AToX", "XToBToC", "AToBToX", "XToC", "BToX"];
    let chain = found(&both, "AToBToC");
    assert!(!matches!(&chain, Ok(c) if c.links().is_empty()), "{chain:?}");
}

#[test]
fn names_are_case_sensitive_and_what_is_missing_is_said() {
    for asked in [
        "stylusToTracker",
        "StylusTotracker",
        "Stylus",
        "",
        "ToTracker",
        "StylusTo",
        "TrackerToTracker",
        "ToToTo",
        "\u{e9}To\u{c9}",
    ] {
        let missing = found(&["StylusToTracker"], asked).unwrap_err();
        assert!(
            missing.to_string().contains("there is no transform"),
            "{asked}: {missing}"
        );
    }
    let many: Vec<String> = (0..300).map(|i| format!("A{i}ToB")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    assert!(matches!(found(&many, "A1ToA2"), Err(NoChain::TooMany { found: 300 })));
    assert!(found(&many, "A1ToB").is_ok());
}

#[test]
fn two_ways_must_end_in_one_place_and_a_link_that_is_lost_loses_all() {
    let chain = found(&["AToB", "BToC", "AToD", "DToC"], "AToC").unwrap();
    let at = |x: f64| rigid([0.0, 0.0, 0.0, x, 0.0, 0.0]);
    let of = |dc: f64| move |name: &str| Some(at(if name == "DToC" { dc } else { 1.0 }));
    assert_eq!(chain.pose(of(1.0)).unwrap().unwrap().translation_mm(), [2.0, 0.0, 0.0]);
    let refused = chain.pose(of(1.1)).unwrap_err().to_string();
    assert!(
        refused.contains("AToB, then BToC and AToD, then DToC end 0.100 mm"),
        "{refused}"
    );
    let lost = |gone: &'static str| move |name: &str| (name != gone).then(|| at(1.0));
    assert_eq!(chain.pose(lost("BToC")).unwrap(), None);
    // The other way alone may be lost.
    assert!(chain.pose(lost("DToC")).unwrap().is_some());
}

proptest! {
    /// Every pair of frames of a random tree with extra links, each stated forwards or backwards: what is composed is what the places
    /// of the frames say.
    #[test]
    fn chains_are_what_the_places_of_the_frames_say(
        places in prop::collection::vec(prop::array::uniform6(-1.5_f64..1.5), 2..9),
        parents in prop::collection::vec((0_usize..8, any::<bool>()), 8),
        extra in prop::collection::vec((0_usize..9, 0_usize..9, any::<bool>()), 0..4),
        from in 0_usize..9, to in 0_usize..9,
    ) {
        let n = places.len();
        let [from, to] = [from % n, to % n];
        prop_assume!(from != to);
        // world_from_frame, mm.
        let world: Vec<NamedRigid> = places.iter().map(|p| rigid([p[0], p[1], p[2], 500.0 * p[3], 500.0 * p[4], 500.0 * p[5]])).collect();
        let tree = (1..n).map(|i| (i, parents[i - 1].0 % i, parents[i - 1].1));
        let extra = extra.into_iter().map(|(a, b, way)| (a % n, b % n, way)).filter(|(a, b, _)| a != b);
        let stated: BTreeMap<String, NamedRigid> = tree
            .chain(extra)
            .map(|(a, b, way)| if way { (a, b) } else { (b, a) })
            .map(|(a, b)| (format!("F{a}ToF{b}"), world[b].inverse() * world[a]))
            .collect();
        let names: BTreeSet<&str> = stated.keys().map(String::as_str).collect();
        let chain = Chain::find(&names, &format!("F{from}ToF{to}")).unwrap();
        let pose = chain.pose(|name| stated.get(name).copied()).unwrap().unwrap();
        // Eight links of at most 1300 mm, each rounded to some 1e-13 of that.
        prop_assert!(apart(&pose, &(world[to].inverse() * world[from])) < 1e-9);
        for gone in chain.links() {
            let lost = chain.pose(|name| stated.get(name).copied().filter(|_| name != gone.name)).unwrap();
            prop_assert!(lost.is_none());
        }
    }
}
