//! What is run.

use super::common::draw::{LEFT, Sweep};
use super::kinds::Kind;

/// How a run begins.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum From {
    /// Degrees and millimetres off; searched within 1.2 times that.
    Guess(f64, f64),
    /// The same, one start followed alone.
    One(f64, f64),
    Nothing,
}

pub(crate) struct Row {
    pub(crate) name: &'static str,
    /// What a refusal means; of a row of [`Kind::Holds`] each run is looked at.
    pub(crate) kind: Kind,
    pub(crate) sweep: Sweep,
    pub(crate) from: From,
    /// Pose alone: depth scale and offset held at 0.
    pub(crate) is_pose_only: bool,
    /// Points of one patch of this radius, mm; 0 takes all.
    pub(crate) patch_mm: f64,
    /// What the solver is told of the noise, times the truth.
    pub(crate) told: f64,
    /// What is the matter with the points beside.
    pub(crate) matter: Matter,
}

/// What is the matter with points.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Matter {
    Nothing,
    /// In the order of a sweep.
    InOrder,
    /// The bone moved by so many mm on the way; in the order of a sweep, or coming back to each place.
    Moved(f64, bool),
    /// Half of the points are those of a probe held still.
    Held,
    /// Of the skin.
    Skin,
    /// Of one stroke.
    Line,
    /// Left for right.
    Mirrored,
    /// Speed of sound and offset of the bone are drawn from their priors.
    Priors,
    /// And the probe's calibration has an error, which is told.
    Shared,
    /// Soft tissue of so many mm on one side.
    OneSided(f64),
    /// This share of the points lies so many mm outside of the bone.
    Raised(f64, f64),
    /// The bone drifts by so many mm in all; in the order of a sweep, or coming back to each place.
    Drifting(f64, bool),
}

pub(crate) fn rows() -> Vec<Row> {
    let all = Sweep::default();
    let crest = Sweep {
        regions: LEFT,
        points: 100,
        ..all
    };
    let row = |name, sweep, from| Row {
        name,
        kind: Kind::Holds,
        sweep,
        from,
        is_pose_only: false,
        patch_mm: 0.0,
        told: 1.0,
        matter: Matter::Nothing,
    };
    // why: who moved, whose points are of the skin or of the other side is not the patient of that pose; a stroke along one line slides on itself.
    let kind_of = |matter| match matter {
        Matter::Moved(mm, _) if mm > 0.0 => Kind::Broken,
        Matter::Skin | Matter::Mirrored | Matter::OneSided(_) | Matter::Raised(..) | Matter::Drifting(..) => {
            Kind::Broken
        }
        Matter::Line => Kind::Weak,
        _ => Kind::Holds,
    };
    let matter = |name, sweep, matter| Row {
        matter,
        kind: kind_of(matter),
        ..row(name, sweep, From::Guess(10.0, 10.0))
    };
    let with = |outliers: f64, sweep: Sweep| Sweep { outliers, ..sweep };
    let fine = |points: usize| Sweep {
        points,
        outliers: 0.0,
        ..all
    };
    let pointer = |points: usize, outliers: f64| Sweep {
        points,
        sigma_mm: [0.4; 3],
        has_beams: false,
        ..with(outliers, all)
    };
    let wrong = Sweep {
        outliers: 0.1,
        speed: 0.04,
        offset_mm: -1.0,
        ..all
    };
    vec![
        row("crests + pubis 200, 20 %, 30/30", all, From::Guess(30.0, 30.0)),
        row("crests + pubis 200, 20 %, 60/50", all, From::Guess(60.0, 50.0)),
        row(
            "crests + pubis 200, 40 %, 20/20",
            with(0.4, all),
            From::Guess(20.0, 20.0),
        ),
        row("one crest 100, 30 %, 10/10", with(0.3, crest), From::Guess(10.0, 10.0)),
        row("one crest 100, 10 %, 10/10", with(0.1, crest), From::Guess(10.0, 10.0)),
        row("no guess 200, 10 %", with(0.1, all), From::Nothing),
        row("no guess 200, 40 %", with(0.4, all), From::Nothing),
        row("one start 200, 20 %, 10/10", all, From::One(10.0, 10.0)),
        row("one start 200, 20 %, 30/30", all, From::One(30.0, 30.0)),
        Row {
            is_pose_only: true,
            ..row("pose only 200, 0 %, 10/10", fine(200), From::Guess(10.0, 10.0))
        },
        Row {
            is_pose_only: true,
            ..row("pose only 500, 0 %, 10/10", fine(500), From::Guess(10.0, 10.0))
        },
        Row {
            is_pose_only: true,
            ..row("pose only 200, 20 %, 10/10", all, From::Guess(10.0, 10.0))
        },
        Row {
            is_pose_only: true,
            ..row(
                "pose only 500, 30 %, 20/20",
                Sweep {
                    points: 500,
                    ..with(0.3, all)
                },
                From::Guess(20.0, 20.0),
            )
        },
        row(
            "all unknowns 500, 30 %, 20/20",
            Sweep {
                points: 500,
                ..with(0.3, all)
            },
            From::Guess(20.0, 20.0),
        ),
        row("pointer 20, 0 %, 10/10", pointer(20, 0.0), From::Guess(10.0, 10.0)),
        row("pointer 20, 10 %, 10/10", pointer(20, 0.1), From::Guess(10.0, 10.0)),
        row("pointer 20, 30 %, 10/10", pointer(20, 0.3), From::Guess(10.0, 10.0)),
        row("pointer 40, 10 %, 10/10", pointer(40, 0.1), From::Guess(10.0, 10.0)),
        row(
            "crests + pubis 60, 30 %, 10/10",
            Sweep {
                points: 60,
                ..with(0.3, all)
            },
            From::Guess(10.0, 10.0),
        ),
        row("bone 1 mm out and 4 % speed, 200, 10 %", wrong, From::Guess(10.0, 10.0)),
        // why: 14 mm of a smooth bone hold neither turn nor slide.
        Row {
            patch_mm: 14.0,
            kind: Kind::Weak,
            ..row(
                "patch of 14 mm, 5 %, 10/10",
                Sweep {
                    points: 6000,
                    ..with(0.05, all)
                },
                From::Guess(10.0, 10.0),
            )
        },
        // why: more echoes than bone, where half is asked for.
        Row {
            kind: Kind::Weak,
            ..row("60 % echoes 200, 20/20", with(0.6, all), From::Guess(20.0, 20.0))
        },
        // why: within 29 degrees was told.
        Row {
            kind: Kind::Broken,
            ..row("guess 180 degrees off, 20 %", all, From::Guess(180.0, 10.0))
        },
        // why: a noise told ten times wrong makes every statement of error, and of other poses, false.
        Row {
            told: 0.1,
            kind: Kind::Broken,
            ..row("noise told 10 x too small", all, From::Guess(10.0, 10.0))
        },
        Row {
            told: 10.0,
            kind: Kind::Broken,
            ..row("noise told 10 x too large", all, From::Guess(10.0, 10.0))
        },
        matter("one crest 100, 10 %, in order", with(0.1, crest), Matter::InOrder),
        matter("skin instead of bone", with(0.1, all), Matter::Skin),
        matter("probe held still, half of 200", with(0.1, all), Matter::Held),
        matter(
            "one stroke over a crest",
            Sweep {
                points: 3000,
                ..with(0.05, crest)
            },
            Matter::Line,
        ),
        matter("left for right", with(0.1, all), Matter::Mirrored),
        matter("in order 200, 10 %", with(0.1, all), Matter::InOrder),
        matter("priors drawn, 200, 10 %", with(0.1, all), Matter::Priors),
        matter("priors drawn, one crest 100", with(0.1, crest), Matter::Priors),
        matter("calibration error 200, 10 %", with(0.1, all), Matter::Shared),
        matter("calibration error, one crest 100", with(0.1, crest), Matter::Shared),
        matter("moved by 0 mm, in order", with(0.1, all), Matter::Moved(0.0, true)),
        matter("moved by 1 mm, in order", with(0.1, all), Matter::Moved(1.0, true)),
        matter("moved by 2 mm, in order", with(0.1, all), Matter::Moved(2.0, true)),
        matter("moved by 3 mm, in order", with(0.1, all), Matter::Moved(3.0, true)),
        matter("moved by 5 mm, in order", with(0.1, all), Matter::Moved(5.0, true)),
        matter("moved by 10 mm, in order", with(0.1, all), Matter::Moved(10.0, true)),
        matter("moved by 1 mm, to and fro", with(0.1, all), Matter::Moved(1.0, false)),
        matter("moved by 2 mm, to and fro", with(0.1, all), Matter::Moved(2.0, false)),
        matter("moved by 3 mm, to and fro", with(0.1, all), Matter::Moved(3.0, false)),
        matter("moved by 5 mm, to and fro", with(0.1, all), Matter::Moved(5.0, false)),
        matter(
            "tissue of 1.5 mm on one side, pointer 40",
            pointer(40, 0.0),
            Matter::OneSided(1.5),
        ),
        matter(
            "40 % raised by 3 mm, pointer 40",
            pointer(40, 0.0),
            Matter::Raised(0.4, 3.0),
        ),
        matter(
            "drift of 2 mm, to and fro, pointer 40",
            pointer(40, 0.0),
            Matter::Drifting(2.0, false),
        ),
        matter(
            "tissue of 1.5 mm on one side, pointer 100",
            pointer(100, 0.0),
            Matter::OneSided(1.5),
        ),
        matter(
            "40 % raised by 3 mm, pointer 100",
            pointer(100, 0.0),
            Matter::Raised(0.4, 3.0),
        ),
        matter(
            "drift of 2 mm, to and fro, pointer 100",
            pointer(100, 0.0),
            Matter::Drifting(2.0, false),
        ),
        matter(
            "drift of 2 mm, in order, pointer 100",
            pointer(100, 0.0),
            Matter::Drifting(2.0, true),
        ),
        matter("clean, in order, pointer 100", pointer(100, 0.0), Matter::InOrder),
        matter(
            "tissue of 1.5 mm on one side, probe 200",
            with(0.1, all),
            Matter::OneSided(1.5),
        ),
        matter(
            "drift of 2 mm, in order, probe 200",
            with(0.1, all),
            Matter::Drifting(2.0, true),
        ),
        row(
            "one crest 20, 10 %, 10/10",
            Sweep {
                points: 20,
                ..with(0.1, crest)
            },
            From::Guess(10.0, 10.0),
        ),
    ]
}
